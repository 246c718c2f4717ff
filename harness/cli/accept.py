"""`rps-bench accept`: what was found becomes what is expected."""

from pathlib import Path

import click

from harness.cli import flags
from harness.cli.check import BASELINE, asks, display, looked
from harness.cli.reproduce import LATEST
from harness.cli.terminal import Bar

ACCEPTED = "results/accepted"


@click.command()
@flags.option("reason", "TEXT", "Why something is accepted that lowers the bar.")
@flags.option("latest", "DIR", f"Tables and figures to accept, or none; default {LATEST}, without "
              "--case-file.")  # fmt: skip
@flags.option("case_file", *flags.FLAGS["case_file"])
@flags.option("baseline", "DIR", f"Figures of the gate; default {BASELINE} without --case-file, "
              "where a folder of your own is needed.")  # fmt: skip
@flags.option("models", "A,B", "These models only, by name.")
@click.option("--quick", is_flag=True, help="Without solids, which take seconds a pose.")
@flags.history()
@flags.time_limit()
def accept(
    reason: str | None,
    latest: str | None,
    case_file: str | None,
    baseline: str | None,
    models: str | None,
    quick: bool,
    history: Path | None,
    time_limit: float,
) -> int:
    """Take results/latest as what README shows, and what a check finds as what the gate expects.

    Tolerances only tighten, unless a reason is given; it is kept. Figures of models that cannot run
    here stay. With --case-file it makes and keeps a baseline of your own mechanism.
    """
    from analytic import InputError
    from harness.accepted import files
    from harness.bench import Bench
    from harness.gate.files import save
    from harness.gate.gate import NotAcceptedError, accepted
    from harness.output import write_all

    asked = asks(case_file, baseline, models, quick=quick, new=True)
    if asked.folder is None:
        raise InputError("baseline", baseline, "a folder to accept figures into")
    if reason is not None and not reason.strip():
        raise InputError("reason", reason, "words")
    source = (LATEST if case_file is None else "none") if latest is None else latest
    shown = {} if source == "none" else files(Path(source))
    with Bar() as bar, Bench(time_limit, bar) as bench:
        report, checked = looked(asked, bench, history)
        try:
            new = accepted(report, checked, bench, reason or "")
        except (NotAcceptedError, InputError) as error:
            refused: str | None = flags.dashed(str(error))
        else:
            refused = None
            save(asked.folder, new)
            if shown:
                write_all(Path(ACCEPTED), shown)
    display(report)
    if refused is not None:
        click.echo(f"rps-bench: {refused}", err=True)
        return 1
    before = 0 if asked.baseline is None else len(asked.baseline.reasons)
    click.echo(f"accepted into {asked.folder}/: {len(report.now.modes)} frequencies, "
               f"{len(new.reasons) - before} with a reason")  # fmt: skip
    if shown:
        click.echo(f"accepted into {ACCEPTED}/: {', '.join(shown)}")
    return 0
