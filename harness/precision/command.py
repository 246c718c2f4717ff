"""`rps-bench work-precision`: time against error, and the cheapest way to a precision."""

from pathlib import Path

import click

from analytic import InputError
from analytic.theory import BEAMS
from harness.history_option import takes_history
from harness.models import parse
from harness.options import CostRequest, Request
from harness.terminal import finish, progress, show, status, write


@click.command(name="work-precision")
@click.option("--cases", metavar="CASE,CASE", help="Cases by name; default case1,case2.")
@click.option("--case-file", metavar="FILE", help="TOML file with cases of your own.")
@click.option("--elements", metavar="S,S", help="Elements of beams; default 1,2,3,4,8,16,32.")
@click.option("--references", metavar="A,B", help="Simulators by name; default all that can run.")
@click.option("--truth", metavar="NAME", help="Solid model to judge by; default calculix-solid.")
@click.option("--repeats", metavar="N", help="How often everything is timed; default 5.")
@click.option("--output", metavar="DIR", help="Folder to write tables and the figure to.")
@takes_history
def precision(
    cases: str | None,
    case_file: str | None,
    elements: str | None,
    references: str | None,
    truth: str | None,
    repeats: str | None,
    output: str | None,
    history: Path | None,
) -> int:
    """Time against error for every model: what an element costs and buys.

    The error is the largest of f1-f3 and of f1-f6 over all cases, once against the exact limit of
    the model's own theory and once against 3-D solids. Ends with the cheapest way to 1, 0.1 and
    0.01 %.
    """
    from harness.precision.report import precision_files, precision_tables
    from harness.precision.ways import TRUTHS, solid_truth, theory_of
    from harness.precision.work_precision import STEPS, truths, work_precision

    asked = Request(cases, case_file, None, elements, None, None, None, output, history)
    timed = CostRequest(elements, references, repeats or "5", None, output, history)
    chosen, programs, rounds = asked.chosen, timed.programs, timed.rounds
    steps = asked.steps(",".join(map(str, STEPS)))
    solid = solid_truth() if truth is None else parse(truth, "--truth")
    if solid is not None and theory_of(solid) in BEAMS:
        raise InputError("--truth", truth, f"a solid model, such as {' or '.join(TRUTHS)}")
    total = len(truths(programs, solid)) * len(chosen) + 1 + rounds
    with progress(total) as done:
        result = work_precision(chosen, steps, programs, solid, rounds, done)
    show(*precision_tables(result).values())
    write(asked.folder, precision_files(result) if asked.folder is not None else {})
    # The truths' study says itself what of it failed.
    others = {k: why for k, why in result.failures.items() if k not in result.study.failures}
    return max(status(others), finish(history, result.study, more=result.rows))
