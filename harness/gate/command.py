"""`rps-bench check`: the gate. What moved since the accepted figures, and what must always hold."""

from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from analytic import InputError
from harness.history_option import takes_history
from harness.options import as_typed, folder, split

if TYPE_CHECKING:
    from harness.gate.gate import Finding
    from harness.gate.ratchet import Baseline, Reason
    from harness.gate.report import Report

DEFAULT = "results/baseline"


@click.command()
@click.option("--baseline", default=DEFAULT, metavar="DIR",
              help=f"Accepted figures, or none; default {DEFAULT}.")  # fmt: skip
@click.option("--models", metavar="A,B", help="These models only, by name.")
@click.option("--quick", is_flag=True, help="Without solids, which take seconds a pose.")
@click.option("--accept", is_flag=True, help="Make what was found the baseline.")
@click.option("--reason", metavar="TEXT", help="Why something is accepted that lowers the bar.")
@click.option("--compare", metavar="A,B",
              help="Instead: --models in environments A and B, as in mujoco==3.17.0.")  # fmt: skip
@click.option("--output", metavar="DIR", help="Folder for check.json, check.md and check.xml.")
@click.option("--json", metavar="FILE", help="Everything, for programs.")
@click.option("--markdown", metavar="FILE", help="A summary as GitHub-flavoured Markdown.")
@click.option("--junit", metavar="FILE", help="JUnit XML.")
@takes_history
def check(
    history: Path | None,
    baseline: str,
    models: str | None,
    quick: bool,
    accept: bool,
    reason: str | None,
    compare: str | None,
    output: str | None,
    **files: str | None,
) -> int:
    """Compare with the accepted figures; exit status 1 if anything moved.

    Solves both cases and a map of the workspace by every model that runs here; compares
    frequencies, shapes, mode counts, orders and seconds with the baseline; and checks what needs
    none: symmetries, units, limits, agreement. Accepting tightens; anything else takes --reason.
    """
    if compare is not None:
        if accept or quick or reason is not None or any(files.values()):
            raise InputError("--compare", compare, "no option beside it but --models and --output")
        return _compare(compare, models, output)
    from harness.gate import study as check_study
    from harness.terminal import progress, show

    target = _target(baseline)
    if accept and target is None:
        raise InputError("--baseline", baseline, "a folder to accept figures into")
    if reason is not None and not (accept and reason.strip()):
        raise InputError("--reason", reason, "words, beside --accept")
    known = _known(target, accept)
    written = _targets(folder(output), files)
    plan = check_study.standard(None if models is None else split("--models", models), quick)
    begin = datetime.now(UTC)
    with progress(plan.solves) as done:
        checked = check_study.solve(plan, done)
    report = _report(checked, known, history, begin)
    from harness.gate.report import findings_table, sentence, summary_table

    show(summary_table(report))
    if report.findings:
        show(findings_table(report))
    for note in report.notes:
        click.echo(note)
    click.echo(f"rps-bench check {sentence(report)}")
    _write(report, written)
    if not accept:
        return 0 if report.passed else 1
    assert target is not None
    return _accept(target, report, checked, known, reason or "", begin)


def _compare(text: str, models: str | None, output: str | None) -> int:
    """Show what the same study gives in two environments."""
    from harness.history.environments import compare, requirements, study
    from harness.terminal import progress, show, write

    both, target = requirements(text), folder(output)
    labels = study(*both, None if models is None else split("--models", models))
    with progress(2 * len(labels)) as done:
        table = compare(*both, labels, done=done)
    show(table)
    write(target, table.files("environments"))
    return 0


def _target(text: str) -> Path | None:
    if text == "" or Path(text).is_file():
        raise InputError("--baseline", text, "the name of a folder, or none")
    return None if text == "none" else Path(text)


def _known(target: Path | None, accept: bool) -> "Baseline | None":
    from harness.gate.ratchet import load

    known = load(target) if target is not None else None
    if known is None and target is not None and not accept:
        expected = "a folder of accepted figures (rps-bench check --accept makes one), or none"
        raise InputError("--baseline", str(target), expected)
    return known


def _targets(output: Path | None, files: dict[str, str | None]) -> list[tuple[str, str, Path]]:
    """Return option, form and path of every file to write."""
    found = [] if output is None else [
        ("--output", form, output / f"check.{suffix}")
        for form, suffix in (("json", "json"), ("markdown", "md"), ("junit", "xml"))
    ]  # fmt: skip
    for form, text in files.items():
        if text is not None:
            if text == "" or Path(text).is_dir():
                raise InputError(f"--{form}", text, "the name of a file")
            found.append((f"--{form}", form, Path(text)))
    return found


def _report(
    checked: Any, known: "Baseline | None", history: Path | None, begin: datetime
) -> "Report":
    """Compare, after adding this run to the history that its seconds are compared with."""
    from harness.gate import gate
    from harness.gate.measured import measure
    from harness.gate.metamorphic import properties
    from harness.gate.report import Report
    from harness.gate.timing_watch import timings
    from harness.history.provenance import provenance
    from harness.history.store import append, open_history

    about = provenance()
    now = measure(checked)
    held = properties(checked)
    findings = gate.failures(checked) + gate.broken(held)
    notes, timed = [], []
    if known is not None:
        findings += gate.compare(known, now)
    else:
        notes.append("compared with no baseline")
    if history is not None:
        append(history, checked.rows, as_typed())
        past = open_history(history)
        accepted = {} if known is None else known.timed_since
        since = {model: datetime.fromisoformat(text) for model, text in accepted.items()}
        timed = timings(past, about["machine"], since)
        # What was not solved now has not changed now.
        timed = [one for one in timed if one.model in {row["model"] for row in checked.rows}]
        findings += gate.slower(timed)
        notes += [f"history: skipped {path}: {why}" for path, why in past.skipped]
    said = {
        "command": as_typed(),
        "time": begin.isoformat(timespec="seconds"),
        "seconds": round((datetime.now(UTC) - begin).total_seconds(), 1),
        **about,
    }
    return Report(tuple(findings), tuple(held), tuple(timed), now, known, said, tuple(notes))


def _write(report: "Report", targets: Sequence[tuple[str, str, Path]]) -> None:
    from harness.files import write_all
    from harness.gate import report as check_report

    forms = {
        "json": check_report.as_json,
        "markdown": check_report.as_markdown,
        "junit": check_report.as_junit,
    }
    for option, form, path in targets:
        write_all(path.parent, {path.name: forms[form](report)}, option)
        click.echo(f"wrote {path}")


def _accept(
    target: Path,
    report: "Report",
    checked: Any,
    known: "Baseline | None",
    reason: str,
    begin: datetime,
) -> int:
    """Make what was found the baseline, unless it must not be."""
    from dataclasses import replace

    from harness.gate.gate import FAILED, condense
    from harness.gate.ratchet import accept, measure_noise, save
    from harness.terminal import progress

    never = [one for one in report.findings if one.fails and one.kind in ("property", "failure")]
    if never:
        click.echo("rps-bench: nothing accepted: properties and failures cannot be", err=True)
        return 1
    lower = [one for one in report.findings if one.verdict == FAILED]
    if lower and not reason:
        said = f"{len(lower)} findings lower the bar: --reason says why they are right"
        click.echo(f"rps-bench: nothing accepted: {said}", err=True)
        return 1
    about = {"time": begin.isoformat(timespec="seconds"), "commit": report.about["commit"]}
    why = _reasons(condense(lower), about, reason)
    with progress(checked.plan.solves) as done:
        noise = measure_noise(checked, done)
    result = accept(known, report.now, noise, about, reason, why)
    changed = {one.model: one for one in report.timings}
    since = {
        one.model: changed[one.model].since.isoformat()
        for one in report.findings
        if one.kind == "timing"
    }
    result = replace(result, timed_since=result.timed_since | since)
    save(target, result)
    wider = len(result.reasons) - len(known.reasons if known else ()) - len(why)
    click.echo(f"accepted into {target}/: {len(report.now.modes)} frequencies; "
               f"{wider} tolerances widened")  # fmt: skip
    return 0


def _reasons(
    lower: Sequence[tuple["Finding", int]], about: dict[str, str], reason: str
) -> list["Reason"]:
    from harness.gate.ratchet import Reason

    return [
        Reason(about["time"], about["commit"], one.quantity, one.model,
               one.case if of == 1 else f"{one.case} (worst of {of})", one.mode or 0,
               str(one.before), str(one.after), reason)
        for one, of in lower
    ]  # fmt: skip
