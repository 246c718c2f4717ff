"""The sections of `rps-bench reproduce`: what each solves, draws and says."""

import io
import json
from collections import Counter
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory

from analytic.theory import BEAMS
from harness import budget as parts
from harness import refinement, slenderness, summary
from harness.cases import PRESETS
from harness.compare import (
    errata_table,
    provenance_table,
    readings_table,
    reference_table,
    table_one,
)
from harness.convergence import converge, convergence_files
from harness.figures import figure_files
from harness.models import Spec, parse
from harness.precision.ways import solid_truth
from harness.reproduce import Done, Part, Plan, Section, tidy
from harness.run import rows, run
from harness.shapes import assurance_figure, shapes_figure
from harness.tables import table_files

LADDER = (1, 2, 4, 8, 16)  # doubling, to read the order of convergence from
BUDGET_STEPS = (1, 2, 3, 4)
ROUNDS = 3
"""How often what is timed is timed."""
COST_STEPS = (1, 2, 4, 8, 16, 32, 64)
BATCHES = (1, 10, 100, 1000, 10_000)


def _models(plan: Plan) -> list[Spec]:
    return [plan.theory, *plan.references, *summary.causes(plan.theory)]


def provenance(plan: Plan, done: Done) -> Part:
    """Where the numbers of Table I and its companions come from."""
    study = run(plan.cases, _models(plan), plan.count, done)
    return Part(provenance_table(study).files("provenance"), summary.closure(study), (study,))


def table1(plan: Plan, done: Done) -> Part:
    """Table I, every reference beside it, and other readings of the paper."""
    study = run(plan.cases, _models(plan), plan.count, done)
    readings = [run([case], [parse(case.model, "model")], 6, done) for case in PRESETS.values()]
    tables = {
        "table1": table_one(study, [plan.theory], plan.references[:1], plan.shown),
        "references": reference_table(study, plan.theory, plan.references, plan.shown),
        "readings": readings_table(readings),
        "errata": errata_table(),
    }
    # Seconds are in provenance.*: frequencies are the same in every run.
    seconds = ("build_s", "solve_s")
    records = [{k: v for k, v in row.items() if k not in seconds} for row in rows(study)]
    files = {"frequencies.csv": tidy(records)} | table_files(tables)
    said = summary.headlines(study, plan.theory, plan.references)
    said += summary.closest_readings(readings)
    said += summary.summarise(study, plan.theory, plan.references)
    return Part(files, said, (study, *readings))


def convergence(plan: Plan, done: Done) -> Part:
    """Fig. 3, and the discretisation error alone."""
    limit = replace(plan.theory, elements=None)
    curves = {
        "fig3": converge(plan.cases, plan.theory, plan.steps, plan.references[0], plan.count, done),
        "discretisation": converge(plan.cases, plan.theory, LADDER, limit, plan.count, done),
    }
    files: dict[str, bytes] = {}
    for stem, result in curves.items():
        files |= convergence_files(result, plan.shown, stem)
    said = summary.orders(curves["discretisation"])
    return Part(files, said, tuple(result.study for result in curves.values()))


def _ladders(plan: Plan) -> list[list[Spec]]:
    theories = [replace(plan.theory, name=name) for name in BEAMS]
    named = [parse(name, "references", plan.theory.shear) for name in plan.names]
    return [refinement.ladder(spec, None) for spec in (*theories, *named)]


def refined(plan: Plan, done: Done) -> Part:
    """Observed order, limit and GCI of every model."""
    ladders = _ladders(plan)
    result = refinement.refine(plan.cases, ladders, plan.count, done)
    files: dict[str, bytes] = {}
    for steps, table in zip(ladders, refinement.refinement_tables(result, plan.shown), strict=True):
        files |= table.files(f"refinement-{steps[0].name}")
    return Part(files, summary.refinements(result), (result.study,))


def _against(plan: Plan) -> dict[str, Spec]:
    """Return what the budget is drawn against, by the ending of its files."""
    first, solid = plan.references[0], solid_truth()
    return {f"-{first.name}": first} | ({} if solid is None else {"": solid})


def budgets(plan: Plan, done: Done) -> Part:
    """The error by cause, against beams that share the theory and against solids."""
    files: dict[str, bytes] = {}
    results = []
    for ending, reference in _against(plan).items():
        result = parts.budget(plan.cases, plan.theory, BUDGET_STEPS, reference, plan.count, done)
        files |= parts.budget_table(result, plan.shown).files(f"budget{ending}")
        if result.shares:
            files |= figure_files(parts.budget_figure(result, plan.shown), f"budget{ending}")
            files |= figure_files(parts.floor_figure(result, plan.shown), f"floor{ending}")
        results.append(result)
    studies = tuple(result.study for result in results)
    return Part(files, [line for r in results for line in summary.causes_of(r)], studies)


def slender(plan: Plan, done: Done) -> Part:
    """Beam theory against solids as rods grow stout."""
    solid = solid_truth() or plan.references[0]
    if solid.name == "calculix-solid":
        solid = replace(solid, elements=(4, 8))  # a tenth of the time of its own 8+12
    result = slenderness.slenderness(plan.cases, slenderness.RATIOS, solid, plan.count, done)
    files = slenderness.slenderness_table(result, plan.shown).files("slenderness")
    files |= figure_files(slenderness.slenderness_figure(result, plan.shown), "slenderness")
    return Part(files, summary.slender(result), result.studies)


def shapes(plan: Plan, done: Done) -> Part:
    """Figs. 4 and 5 beside the references, with the assurance matrices."""
    against = list(_against(plan).values())
    study = run(plan.cases, [plan.theory, *against], plan.count, done)
    files: dict[str, bytes] = {}
    for case in plan.cases:
        figure = shapes_figure(study, case, [plan.theory, *against], plan.shown)
        files |= figure_files(figure, f"shapes-{case.name}", forms=("png",))
        for reference in against:
            matrix = assurance_figure(study, case, plan.theory, reference, plan.shown)
            if matrix is not None:
                files |= figure_files(matrix, f"assurance-{case.name}-{reference.name}")
    return Part(files, summary.alike(study, plan.theory, against), (study,))


def precision(plan: Plan, done: Done) -> Part:
    """Time against error, and the cheapest way to a precision."""
    from harness.precision.report import precision_files, precision_sentences
    from harness.precision.work_precision import STEPS, work_precision

    result = work_precision(plan.cases, STEPS, plan.names, solid_truth(), ROUNDS, done)
    said = precision_sentences(result)
    return Part(precision_files(result), said, (result.study,), result.failures, result.rows)


def _precision_steps(plan: Plan) -> int:
    from harness.precision.work_precision import truths

    return len(plan.cases) * len(truths(plan.names, solid_truth())) + 1 + ROUNDS


def cost(plan: Plan, done: Done) -> Part:
    """Seconds against s and against the number of poses."""
    from harness.precision.cost import measure
    from harness.precision.cost_report import cost_files, cost_sentences

    beams = [name for name in plan.names if not name.endswith(("solid", "averaged", "ffrf"))]
    result = measure(COST_STEPS, beams, BATCHES, ROUNDS, done)
    said = cost_sentences(result)
    return Part(cost_files(result), said, failures=result.failures, rows=result.rows)


def _command(
    module: str, name: str, said: Callable[[str, dict[str, bytes]], list[str]], *arguments: str,
    under: str = "",
) -> Callable[[Plan, Done], Part]:  # fmt: skip
    """Return a section that is a command: it runs `name` of `module`, takes its files and rows.

    `said` makes sentences of what it prints and writes; `under`: the folder its files go to.
    """

    def make(_: Plan, done: Done) -> Part:
        from harness.history.store import open_history

        command = getattr(import_module(module), name)
        with TemporaryDirectory() as folder:
            output, history = Path(folder) / "output", Path(folder) / "history"
            places = ["--output", str(output), "--history", str(history)]
            out, err = io.StringIO(), io.StringIO()
            with redirect_stdout(out), redirect_stderr(err):
                status = command.main([*arguments, *places], standalone_mode=False)
            files = {f"{under}{path.name}": path.read_bytes()
                     for path in sorted(output.glob("*"))}  # fmt: skip
            # Its rows are of the run that this section is part of, not of one of its own.
            found = open_history(history).query("SELECT * EXCLUDE (run, time, command) FROM rows")
        done(name)
        failures = {("all cases", name): err.getvalue().strip()} if status else None
        return Part(files, said(out.getvalue(), files), failures=failures, rows=found.to_dicts())

    return make


def _bullets(printed: str, _: dict[str, bytes]) -> list[str]:
    return [line.removeprefix("- ") for line in printed.splitlines() if line.startswith("- ")]


def _verdicts(_: str, files: dict[str, bytes]) -> list[str]:
    claims = json.loads(files["claims.json"])
    kinds = Counter(claim["kind"] for claim in claims)
    counts = ", ".join(f"{number} {kind!r}" for kind, number in kinds.most_common())
    return [f"Of {len(claims)} statements of the paper: {counts}."]


SECTIONS = (
    Section("table1", "Table I", "rps-bench table",
            lambda p: len(p.cases) * len(set(_models(p))) + len(PRESETS), table1),
    Section("provenance", "Where the numbers come from", "rps-bench table",
            lambda p: len(p.cases) * len(set(_models(p))), provenance, timed=True),
    Section("convergence", "Fig. 3 and discretisation", "rps-bench convergence",
            lambda p: len(p.cases) * (len(p.steps) + len(LADDER) + 2), convergence),
    Section("refinement", "Order, limit and uncertainty of every model", "rps-bench refine",
            lambda p: len(p.cases) * sum(map(len, _ladders(p))), refined),
    Section("budget", "Error budget", "rps-bench budget",
            lambda p: sum(
                len(p.cases) * len(parts.models(p.theory, BUDGET_STEPS, spec))
                for spec in _against(p).values()
            ), budgets),
    Section("slenderness", "Slenderness", "rps-bench slenderness",
            lambda p: 3 * len(p.cases) * len(slenderness.RATIOS), slender),
    Section("shapes", "Mode shapes, Figs. 4 and 5", "rps-bench shapes",
            lambda p: len(p.cases) * (1 + len(_against(p))), shapes),
    Section("work-precision", "Work and precision", "rps-bench work-precision",
            _precision_steps, precision, timed=True),
    Section("cost", "Cost", "rps-bench cost", lambda _: 1 + ROUNDS, cost, timed=True),
    Section("workspace", "Workspace, Fig. 6", "rps-bench workspace", lambda _: 1,
            _command("harness.workspace.command", "workspace", _bullets,
                     under="workspace/")),
    Section("claims", "Claims", "rps-bench claims", lambda _: 1,
            _command("harness.claims.command", "claims", _verdicts), timed=True),
    Section("identification", "Identification", "rps-bench identify", lambda _: 1,
            _command("harness.identification.command", "identify", _bullets)),
)  # fmt: skip
