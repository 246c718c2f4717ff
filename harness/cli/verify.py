"""`rps-bench verify`: what a model's author should know before anyone believes it."""

import click

from harness.cli import flags
from harness.cli.terminal import Bar, show


@click.command()
@click.argument("model")
@flags.time_limit()
def verify(model: str, time_limit: float) -> int:
    """Tell a model's author what of it fails, and how; exit status 1 if anything does.

    MODEL is a name of `rps-bench models`. Asked at the paper's two cases: units, joints, mode
    counts, modal mass, symmetry, convergence, repeated modes, limits, and how it refuses.
    """
    from harness.bench import Bench
    from harness.verify import verify as verified

    with Bar() as bar, Bench(time_limit, bar) as bench:
        found = verified(model, bench)
    show({"": found})
    for what, why in found.failures().items():
        click.echo(f"rps-bench: {what}: {why}", err=True)
    return 0 if found.passed else 1
