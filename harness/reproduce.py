"""The main job: every study of the list for one plan; one that cannot be made costs no other."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from types import ModuleType

from analytic import InputError
from analytic.errors import unknown
from harness.bench import Bench
from harness.plain import plain
from harness.request import Plan, Request
from harness.result import Result
from harness.studies import STUDIES, Entry
from harness.text import options
from reference_models import ModelError, UnavailableError

TOP = "# {title}\n\nFrom `rps-bench reproduce`, about the cases {cases}. {more}\n"
WHERE = (
    "Where to look: `table1.md` has every frequency, `findings.md` all that was found, "
    "`seconds.md` what holds seconds, `index.html` all of it with figures."
)
FINDINGS = "This depends on the programs alone; `seconds.md` differs from run to run."
SECONDS = "These differ from run to run; `findings.md` has what does not."


@dataclass(frozen=True)
class Part:
    """What one study of the main job made: `results` by the stem of their files, or `why` not."""

    entry: Entry
    results: dict[str, Result]
    why: str = ""

    def sentences(self) -> list[str]:
        """Return what all its results say, and why there are no more."""
        lines = [line for result in self.results.values() for line in result.sentences()]
        return [plain(line) for line in (*lines, *([f"Not made: {self.why}."] if self.why else []))]


def chosen(names: Sequence[str] | None) -> list[Entry]:
    """Return the studies called `names`, or all of them, in their own order."""
    known = [entry.name for entry in STUDIES]
    for name in names or []:
        if name not in known:
            raise unknown("only", name, known)
    return [entry for entry in STUDIES if names is None or entry.name in names]


def reproduce(entries: Sequence[Entry], plan: Plan, bench: Bench) -> Iterator[Part]:
    """Yield what every study of `entries` makes of `plan`."""
    for entry in entries:
        module = entry.load()
        results: dict[str, Result] = {}
        try:
            for stem, one in jobs(entry, module, plan).items():
                results[stem] = module.run(one, bench)
        except (ModelError, UnavailableError, InputError) as error:
            yield Part(entry, results, str(error))
        else:
            if results:
                yield Part(entry, results)


def jobs(entry: Entry, module: ModuleType, plan: Plan) -> dict[str, Request]:
    """Return what the main job asks of a study, by the stem of its files."""
    found: dict[str, Request]
    if not hasattr(module, "jobs"):
        found = {entry.name: plan.request()}
    elif module.jobs is None:
        return {}
    else:
        found = module.jobs(plan)
    usual = options(module, {})
    return {stem: one.with_(options={**usual, **one.options}) for stem, one in found.items()}


def summaries(plan: Plan, parts: Sequence[Part]) -> dict[str, bytes]:
    """Return what the results say as Markdown: the most important in one screen, and all of it.

    Seconds are in a file of their own.
    """
    cases = ", ".join(plain(case.name) for case in plan.cases)
    lasting, timed = ([p for p in parts if p.entry.timed is kind] for kind in (False, True))
    files = {
        "summary.md": f"# Summary of {cases}\n\n{short(lasting)}\n{WHERE}\n",
    }
    for name, title, more, some in (
        ("findings.md", "Findings", FINDINGS, lasting),
        ("seconds.md", "Seconds", SECONDS, timed),
    ):
        lines = [TOP.format(title=title, cases=cases, more=more)]
        for part in some:
            lines.append(f"## {part.entry.title}\n\nFrom `rps-bench {part.entry.name}`.\n")
            lines.append("".join(f"- {line}\n" for line in part.sentences()) or "- nothing\n")
        files[name] = "\n".join(lines)
    return {name: text.encode() for name, text in files.items()}


def short(parts: Sequence[Part]) -> str:
    """Return the verdict, and the findings that belong in one screen, a number each."""
    said = [(part.entry.lead, part.sentences()) for part in parts]
    lead = [line for number, lines in said for line in lines[:number]]
    lead = lead or [line for _, lines in said for line in lines[:1]]
    found = [f"{k}. {line}\n" for k, line in enumerate(lead[1:], 1)]
    return "".join([f"{line}\n" for line in lead[:1]] + ["\n"] * bool(found) + found)
