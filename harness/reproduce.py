"""The main job: every study of the list for one plan; one that cannot be made costs no other."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from types import ModuleType

from analytic import InputError
from harness.bench import Bench
from harness.plan import Plan
from harness.request import Request
from harness.result import Result
from harness.studies import STUDIES, Entry
from harness.text import request
from reference_models import ModelError, UnavailableError

TOP = """# Summary

Written by `rps-bench reproduce`, about the cases {cases}. `--only NAME,NAME` makes single parts.
{seconds}
"""
SECONDS = {
    False: "Parts that hold seconds are in `seconds.md`; this depends on the programs alone.",
    True: "These parts hold seconds, which differ from run to run; `summary.md` has the others.",
}


@dataclass(frozen=True)
class Part:
    """What one study of the main job made: `results` by the stem of their files, or `why` not."""

    entry: Entry
    results: dict[str, Result]
    why: str = ""

    def sentences(self) -> list[str]:
        """Return what all its results say."""
        if self.why:
            return [f"Not made: {self.why}."]
        return [line for result in self.results.values() for line in result.sentences()]


def chosen(names: Sequence[str] | None) -> list[Entry]:
    """Return the studies called `names`, or all of them, in their own order."""
    known = [entry.name for entry in STUDIES]
    for name in names or []:
        if name not in known:
            raise InputError("only", name, f"some of {', '.join(known)}")
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
    usual = request(module, {}).options
    return {stem: one.with_(options={**usual, **one.options}) for stem, one in found.items()}


def summaries(plan: Plan, parts: Sequence[Part]) -> dict[str, bytes]:
    """Return what the results say, study by study, as Markdown; seconds in a file of their own."""
    files = {}
    for name, timed in (("summary.md", False), ("seconds.md", True)):
        cases = ", ".join(case.name for case in plan.cases)
        lines = [TOP.format(cases=cases, seconds=SECONDS[timed])]
        for part in parts:
            if part.entry.timed == timed:
                lines.append(f"## {part.entry.title}\n\nFrom `rps-bench {part.entry.name}`.\n")
                lines.append("".join(f"- {line}\n" for line in part.sentences()) or "- nothing\n")
        files[name] = "\n".join(lines).encode()
    return files
