"""The gate's commands: `check` says what moved, and `accept` takes it as what is expected."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from analytic import InputError
from harness.accepted import ACCEPTED, BASELINE
from harness.cli import flags
from harness.cli.flags import LATEST
from harness.cli.terminal import Bar, show_tables, wrote
from harness.plain import plain

if TYPE_CHECKING:
    from harness.gate.figures import Figures
    from harness.gate.plan import Plan
    from harness.gate.report import Report


def _gate(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options that both commands have."""
    for option in (
        flags.time_limit(),
        flags.history(),
        click.option("--quick", is_flag=True, help="Without solids, which take seconds a pose."),
        flags.option("models", "A,B", "These models only, by name."),
        flags.option("baseline", "DIR", f"Accepted figures, or none; default {BASELINE}, or the "
                     "release's; with --case-file a folder of your own is needed."),
        flags.standard("case_file"),
    ):  # fmt: skip
        command = option(command)
    return command


@click.command()
@_gate
@flags.option("compare", "A,B",
              "Instead: --models in environments A and B, as in mujoco==3.17.0.")  # fmt: skip
@flags.output()
@flags.option("json", "FILE", "Everything, for programs.")
@flags.option("markdown", "FILE", "A summary as GitHub-flavoured Markdown.")
@flags.option("junit", "FILE", "JUnit XML.")
def check(
    compare: str | None,
    output: Path | None,
    history: Path | None,
    time_limit: float,
    **texts: Any,
) -> int:
    """Compare with the accepted figures; exit status 1 if anything moved.

    Solves both cases and a map of the workspace by every model that runs here; compares
    frequencies, shapes, mode counts, orders and seconds with the baseline; and checks what needs
    none: symmetries, units, limits, agreement. `rps-bench accept` takes what was found.
    """
    from harness.bench import Bench
    from harness.gate.gate import run
    from harness.gate.report import FORMS
    from harness.output import check_file, write_all
    from harness.report.page import renewed

    files = {form: texts.pop(form) for form in FORMS}
    if compare is not None:
        models = texts.pop("models")
        if any(texts.values()) or any(files.values()):
            raise InputError("compare", compare, "no option beside it but --models and --output")
        return _compare(compare, models, output, time_limit)
    targets = [] if output is None else [(f, output / name) for f, (name, _) in FORMS.items()]
    targets += [(form, check_file(text, form)) for form, text in files.items() if text is not None]
    plan, _, known = _asked(**texts)
    with Bar() as bar, Bench(time_limit, bar) as bench:
        report = run(plan, known, bench, history, flags.as_typed())
    for form, path in targets:
        write_all(path.parent, {path.name: FORMS[form][1](report)})
    if output is not None:
        write_all(output, renewed(output, history))
    _display(report)
    wrote(path for _, path in targets)
    return 0 if report.passed else 1


@click.command()
@flags.option("reason", "TEXT", "Why something is accepted that lowers the bar.")
@flags.option("latest", "DIR", f"Tables and figures to accept, or none; default {LATEST}, without "
              "--case-file.")  # fmt: skip
@_gate
def accept(
    reason: str | None,
    latest: str | None,
    history: Path | None,
    time_limit: float,
    **texts: Any,
) -> int:
    """Take results/latest as what README shows, and what a check finds as what the gate expects.

    Tolerances only tighten, unless a reason is given; it is kept. Figures of models that cannot run
    here stay. With --case-file it makes and keeps a baseline of your own mechanism.
    """
    from harness.accepted import files, unlike
    from harness.bench import Bench
    from harness.gate.figures import save
    from harness.gate.gate import NotAcceptedError, accepted, run
    from harness.output import write_all

    plan, folder, known = _asked(**texts, new=True)
    if folder is None:
        raise InputError("baseline", texts["baseline"], "a folder to accept figures into")
    if reason is not None and not reason.strip():
        raise InputError("reason", reason, "words")
    usual = LATEST if texts["case_file"] is None else "none"
    source = usual if latest is None else latest
    shown = {} if source == "none" else files(Path(source))
    if shown and not reason and (why := unlike(Path(source), known.simulators if known else ())):
        expected = f"what the main job wrote, none, or a --reason to show another run ({why})"
        raise InputError("latest", source, expected)
    refused = ""
    with Bar() as bar, Bench(time_limit, bar) as bench:
        report = run(plan, known, bench, history, flags.as_typed())
        try:
            new = accepted(report, reason or "")
        except (NotAcceptedError, InputError) as error:
            refused = flags.dashed(str(error))
    if not refused:
        save(folder, new)
        write_all(Path(ACCEPTED), shown)
    _display(report)
    if refused:
        click.echo(f"rps-bench: {plain(refused)}", err=True)
        return 1
    reasons = len(new.reasons) - len(known.reasons if known else ())
    click.echo(f"accepted into {folder}/: {len(report.now.modes)} frequencies, "
               f"{reasons} with a reason")  # fmt: skip
    if shown:
        click.echo(f"accepted into {ACCEPTED}/: {', '.join(shown)}")
    return 0


def _asked(
    case_file: str | None, baseline: str | None, models: str | None, quick: bool, new: bool = False
) -> tuple["Plan", Path | None, "Figures | None"]:
    """Return the plan, the baseline's folder and what is in it; `new`: where one may be made.

    Raises `InputError` naming the argument that is wrong, before anything is solved.
    """
    from harness.accepted import baseline as usual
    from harness.gate.figures import load
    from harness.gate.plan import standard
    from harness.output import check_folder
    from harness.presets import PAPER_CASES
    from harness.text import chosen, split

    cases = chosen(None, case_file, PAPER_CASES)
    if baseline is None and case_file is not None:
        expected = "a folder for the figures of your own cases, or none"
        raise InputError("baseline", baseline, expected)
    text = (BASELINE if new else str(usual())) if baseline is None else baseline
    folder = None if text == "none" else check_folder(text, "baseline")
    known = None if folder is None else load(folder)
    if known is None and folder is not None and not new:
        expected = "a folder of accepted figures (rps-bench accept makes one), or none"
        raise InputError("baseline", text, expected)
    names = None if models is None else split("models", models)
    return standard(cases, names, quick=quick), folder, known


def _display(report: "Report") -> None:
    """Print how much was compared, what moved, and the outcome."""
    show_tables(*(table for end, table in report.tables().items() if end in ("", "-findings")))
    outcome, *notes = report.sentences()
    for line in (*notes, outcome):
        click.echo(plain(line))


def _compare(text: str, models: str | None, output: Path | None, limit: float) -> int:
    """Show what the same study gives in two environments."""
    from harness.environments import compare, requirements, study
    from harness.output import write_all
    from harness.presets import PAPER_CASES
    from harness.text import chosen, split

    both = requirements(text)
    named = study(*both, None if models is None else split("models", models))
    with Bar() as bar:
        table = compare(*both, chosen(None, None, PAPER_CASES), named, limit=limit, listener=bar)
    paths = [] if output is None else write_all(output, table.files("environments"))
    show_tables(table)
    wrote(paths)
    return 0
