"""The studies: one file or package each, and one line here.

A study is a module with `run(request, bench) -> Result`, and where the defaults do not fit:

- `TAKES`: names of the standard arguments that it takes (default: all of `STANDARD`);
- `DEFAULTS`: texts of standard arguments that differ from the usual ones;
- `STEM`: what its files are called (default: its name);
- `OUTPUT`: the folder that its files go to where none is named (default: none is written);
- `OPTIONS`: its own arguments, each an `Option`;
- `EACH_REFERENCE`: true where it compares with one reference, and runs once for each of several;
- `jobs(plan) -> {stem: Request}`: what the main job asks of it (default: the plan as it is, written
  to files called by the study's name). A module whose `jobs` is None has no part in the main job.
"""

from dataclasses import dataclass
from importlib import import_module
from types import ModuleType

STANDARD = ("cases", "case_file", "references", "elements", "modes", "model", "shear")
"""The arguments that studies take unless they say otherwise."""


@dataclass(frozen=True)
class Entry:
    """One study: `name` of its command, `module`, and what it shows, in a whole sentence.

    `share`: its part of the main job's time, in per cent as once measured, for the bar; `timed`:
    whether its answer holds seconds, which differ from run to run; `lead`: how many of its
    sentences belong in a summary.
    """

    name: str
    module: str
    help: str
    title: str
    share: int = 3
    timed: bool = False
    lead: int = 0

    def load(self) -> ModuleType:
        """Return the module, loaded now."""
        return import_module(self.module)


STUDIES = (
    Entry("table", "harness.studies.table",
          "Compare models at cases as Table I does, beside what the paper prints.", "Table I",
          share=2, lead=3),
    Entry("convergence", "harness.studies.convergence",
          "Show the error against the number of elements s, as Fig. 3 does.",
          "Fig. 3 and discretisation",
          share=1, lead=1),
    Entry("refine", "harness.studies.refinement",
          "Read the observed order, the limit and its uncertainty from three meshes.",
          "Order, limit and uncertainty of every model",
          share=6),
    Entry("budget", "harness.studies.budget",
          "Split the error into its causes: elements, rotary inertia, shear and what remains.",
          "Error budget",
          share=3),
    Entry("slenderness", "harness.studies.slenderness",
          "Compare beam theories with solids as rods grow stout.", "Slenderness",
          share=3, lead=1),
    Entry("shapes", "harness.studies.shapes",
          "Draw mode shapes beside a reference's, as Figs. 4 and 5 do.",
          "Mode shapes, Figs. 4 and 5",
          share=4, lead=1),
    Entry("stiffness", "harness.studies.stiffness",
          "Show the static stiffness at the platform, and which part gives way most.",
          "Static stiffness"),
    Entry("work-precision", "harness.studies.precision",
          "Set time against error for every model, and name the cheapest way to a precision.",
          "Work and precision",
          share=23, timed=True),
    Entry("cost", "harness.studies.cost",
          "Measure the cost against elements and poses, as ratios within one run.", "Cost",
          share=28, timed=True),
    Entry("workspace", "harness.studies.workspace",
          "Map the frequencies over the regular workspace, as Fig. 6 does.", "Workspace, Fig. 6",
          share=5),
    Entry("claims", "harness.studies.claims",
          "Judge every statement of the paper that can be checked.", "Claims",
          share=20, timed=True),
    Entry("identify", "harness.studies.identification",
          "Find which mechanism a table of frequencies belongs to.", "Identification",
          share=5),
)  # fmt: skip


def find(name: str) -> Entry:
    """Return the study called `name`, or raise `InputError` with the names there are."""
    for entry in STUDIES:
        if entry.name == name:
            return entry
    from analytic.errors import unknown

    raise unknown("study", name, [entry.name for entry in STUDIES])
