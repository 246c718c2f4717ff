"""`rps-bench cost`: what every model costs, all timed in one run."""

import click

from harness.options import CostRequest, takes_cost_request
from harness.terminal import finish, progress, show, status, write


@click.command()
@takes_cost_request
def cost(request: CostRequest) -> int:
    """Seconds and dofs of every model against s and batch size, beside the paper's claims.

    All in one run on one BLAS thread, interleaved, as ratios to one dense eigen-solution.
    """
    from harness.precision.cost import measure
    from harness.precision.cost_report import cost_files, cost_tables

    steps, programs, poses = request.steps, request.programs, request.poses
    rounds, folder = request.rounds, request.folder
    with progress(1 + rounds) as done:
        result = measure(steps, programs, poses, rounds, done)
    show(*cost_tables(result).values())
    write(folder, cost_files(result) if folder is not None else {})
    return max(status(result.failures), finish(request.history, more=result.rows))
