"""`rps-bench claims`: every checkable statement of the paper, and its verdict."""

from pathlib import Path

import click

from harness.history_option import takes_history
from harness.options import folder, split
from harness.terminal import finish, progress, show, write


@click.command()
@click.option("--only", metavar="ID,ID", help="Check these claims; default all.")
@click.option("--json", "as_json", is_flag=True, help="Print a JSON list instead of a table.")
@click.option("--output", metavar="DIR", help="Folder to write CSV, Markdown, LaTeX and JSON to.")
@takes_history
def claims(only: str | None, as_json: bool, output: str | None, history: Path | None) -> int:
    """Check the paper's statements: quoted, measured, uncertainty and verdict.

    Verdicts are results: only a claim that could not be checked makes the exit status 1.
    """
    from harness.claims.claims import COLUMNS, SHORT, claims_json, claims_table, judge, needed
    from harness.claims.data import claims as every
    from harness.claims.data import select
    from harness.claims.measure import gather

    target = folder(output)
    chosen = list(every()) if only is None else select(split("--only", only))
    groups = needed(chosen)
    with progress(len(groups)) as done:
        facts, missing, solved = gather(groups, done)
    found, unchecked = judge(chosen, facts, missing)
    text = claims_json(found)
    if as_json:
        click.echo(text, nl=False)
    else:
        show(claims_table(found, unchecked, SHORT if only is None else COLUMNS))
    if target is not None:
        files = claims_table(found, unchecked).files("claims")
        write(target, files | {"claims.json": text.encode()})
    for name, why in unchecked.items():
        click.echo(f"rps-bench: {name} could not be checked: {why}", err=True)
    return max(1 if unchecked else 0, finish(history, more=solved))
