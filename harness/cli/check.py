"""`rps-bench check`: the gate. What moved since the accepted figures, and what must always hold."""

from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import click

from harness.cli import flags
from harness.cli.terminal import Bar, show_tables

if TYPE_CHECKING:
    from harness.bench import Bench
    from harness.gate.plan import Checked, Plan
    from harness.gate.ratchet import Baseline
    from harness.gate.report import Report
    from harness.gate.timing_watch import Timing

BASELINE = "results/accepted/baseline"
FILES = {"json": "check.json", "markdown": "check.md", "junit": "check.xml"}
"""What --output writes, by the option that writes it elsewhere."""


@dataclass(frozen=True)
class Asked:
    """What a check is asked for: the `plan`, where the baseline is (None: nowhere) and what it is.

    `baseline` is None where there is none.
    """

    plan: "Plan"
    folder: Path | None
    baseline: "Baseline | None"


@click.command()
@flags.option("case_file", *flags.FLAGS["case_file"])
@flags.option("baseline", "DIR", f"Accepted figures, or none; default {BASELINE} without "
              "--case-file, where a folder of your own is needed.")  # fmt: skip
@flags.option("models", "A,B", "These models only, by name.")
@click.option("--quick", is_flag=True, help="Without solids, which take seconds a pose.")
@flags.option("compare", "A,B",
              "Instead: --models in environments A and B, as in mujoco==3.17.0.")  # fmt: skip
@flags.output()
@flags.option("json", "FILE", "Everything, for programs.")
@flags.option("markdown", "FILE", "A summary as GitHub-flavoured Markdown.")
@flags.option("junit", "FILE", "JUnit XML.")
@flags.history()
@flags.time_limit()
def check(
    case_file: str | None,
    baseline: str | None,
    models: str | None,
    quick: bool,
    compare: str | None,
    output: Path | None,
    history: Path | None,
    time_limit: float,
    **files: str | None,
) -> int:
    """Compare with the accepted figures; exit status 1 if anything moved.

    Solves both cases and a map of the workspace by every model that runs here; compares
    frequencies, shapes, mode counts, orders and seconds with the baseline; and checks what needs
    none: symmetries, units, limits, agreement. `rps-bench accept` takes what was found.
    """
    from harness.bench import Bench
    from harness.gate.report import FORMS
    from harness.output import write_all

    if compare is not None:
        from analytic import InputError

        if case_file or baseline or quick or any(files.values()):
            raise InputError("compare", compare, "no option beside it but --models and --output")
        return _compare(compare, models, output, time_limit)
    targets = _targets(output, files)
    asked = asks(case_file, baseline, models, quick=quick)
    with Bar() as bar, Bench(time_limit, bar) as bench:
        report, _ = looked(asked, bench, history)
    for form, path in targets:
        write_all(path.parent, {path.name: FORMS[form](report)})
    display(report)
    for _, path in targets:
        click.echo(f"wrote {path}")
    return 0 if report.passed else 1


def asks(
    case_file: str | None,
    baseline: str | None,
    models: str | None,
    *,
    quick: bool,
    new: bool = False,
) -> Asked:
    """Return what the texts ask for; `new`: where a baseline may be made.

    Raises `InputError` naming the argument that is wrong, before anything is solved.
    """
    from analytic import InputError
    from harness.gate.files import load
    from harness.gate.plan import standard
    from harness.output import check_folder
    from harness.presets import PAPER_CASES
    from harness.text import chosen, split

    cases = chosen(None, case_file, PAPER_CASES)
    if baseline is None and case_file is not None:
        expected = "a folder for the figures of your own cases, or none"
        raise InputError("baseline", baseline, expected)
    text = BASELINE if baseline is None else baseline
    folder = None if text == "none" else check_folder(text, "baseline")
    known = None if folder is None else load(folder)
    if known is None and folder is not None and not new:
        expected = "a folder of accepted figures (rps-bench accept makes one), or none"
        raise InputError("baseline", text, expected)
    names = None if models is None else split("models", models)
    return Asked(standard(cases, names, quick=quick), folder, known)


def looked(asked: Asked, bench: "Bench", history: Path | None) -> tuple["Report", "Checked"]:
    """Solve and compare; this run is in the history that its seconds are compared with."""
    from harness.gate import gate
    from harness.gate.plan import solve
    from harness.history.provenance import provenance

    began = perf_counter()
    said = {
        "command": flags.as_typed(),
        "time": datetime.now(UTC).isoformat(timespec="seconds"),
        **provenance(),
    }
    checked = solve(asked.plan, bench)
    timed: list[Timing] = []
    notes: list[str] = []
    if history is not None:
        from harness.history.store import append

        append(history, checked.rows, flags.as_typed())
        timed, notes = gate.watched(history, checked, asked.baseline, str(said["machine"]))
    report = gate.look(checked, bench, asked.baseline, timed, said, notes)
    seconds = round(perf_counter() - began, 1)
    return replace(report, about={**report.about, "seconds": seconds}), checked


def display(report: "Report") -> None:
    """Print how much was compared, what moved, and the outcome."""
    tables = report.tables()
    show_tables(*(tables[ending] for ending in ("", "-findings") if ending in tables))
    outcome, *notes = report.sentences()
    for line in (*notes, outcome):
        click.echo(line)


def _compare(text: str, models: str | None, output: Path | None, limit: float) -> int:
    """Show what the same study gives in two environments."""
    from harness.environments import compare, requirements, study
    from harness.output import write_all
    from harness.presets import PAPER_CASES
    from harness.text import chosen, split

    both = requirements(text)
    named = study(*both, None if models is None else split("models", models))
    cases = chosen(None, None, PAPER_CASES)
    with Bar() as bar:
        table = compare(*both, cases, named, limit=limit, listener=bar)
    paths = write_all(output, table.files("environments")) if output is not None else []
    show_tables(table)
    for path in paths:
        click.echo(f"wrote {path}")
    return 0


def _targets(output: Path | None, files: dict[str, str | None]) -> list[tuple[str, Path]]:
    """Return form and path of every file to write."""
    from harness.output import check_file

    found = [] if output is None else [(form, output / name) for form, name in FILES.items()]
    return found + [
        (form, check_file(text, form)) for form, text in files.items() if text is not None
    ]
