"""`rps-bench history`: the runs so far: listed, filtered, asked in SQL, exported."""

from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from analytic import InputError
from harness.cli import flags

if TYPE_CHECKING:
    from harness.tables import Cell

SHOWN = 200
"""Rows a terminal shows; --export has them all."""
FORMATS = (".csv", ".parquet", ".json")
_RUNS = """
SELECT run AS "Run", strftime(time, '%Y-%m-%d %H:%M:%S') AS "Time (UTC)",
  ifnull(regexp_replace(any_value(command), '^rps-bench ', ''), '') AS "Command",
  ifnull(regexp_replace(any_value(commit), '^([^-]{{12}})[^-]*', '\\1'), '') AS "Commit",
  ifnull(any_value(release), '') AS "Release", count(*) AS "Rows",
  concat_ws(', ', any_value('python ' || python), any_value('numpy ' || numpy),
    any_value('scipy ' || scipy),
    string_agg(DISTINCT version, ', ' ORDER BY version)
      FILTER (NOT regexp_matches(version, '^(rps-bench|numpy)'))) AS "Versions"
FROM rows {where} GROUP BY run, time ORDER BY time, run
"""
_BRIEF = (
    'run, "case", model, settings, mode, frequency_hz, uncertainty_hz, assurance, closure_m, dofs, '
    "build_s, solve_s, version"
)
_LATEST = "(SELECT max_by(run, time) FROM rows)"
_FILTERS = {
    "run": "starts_with(run, {0})",
    "since": "time >= {0}::TIMESTAMP",
    "command": "split_part(command, ' ', 2) IN ({0})",
    # A bare name is that model with any elements.
    "model": "(model IN ({0}) OR split_part(model, '@', 1) IN ({0}))",
    "case": '"case" IN ({0})',
    "mode": "mode IN ({0})",
}


@click.command()
@flags.option("run", "RUN", "One run, by the start of its name, or latest.")
@flags.option("since", "DATE", "Runs from then on, as in 2026-01-31 or with a time.")
@flags.option("command", "A,B", "Runs of these commands, such as table,check.")
@flags.option("model", "A,B", "These models: NAME, or NAME@ELEMENTS.")
@flags.option("case", "CASE,CASE", "These cases.")
@flags.option("mode", "I,I", "These mode numbers.")
@click.option("--rows", "as_rows", is_flag=True, help="Show the rows, not the runs.")
@flags.option("sql", "SELECT", 'Any query, as in "SELECT max(dofs) FROM rows".')
@flags.option("export", "FILE", "Write all rows found: .csv, .parquet or .json.")
@flags.history()
def history(
    history: Path | None, as_rows: bool, sql: str | None, export: str | None, **given: str | None
) -> int:
    """List the runs so far; filter them, show their rows, or export these.

    Times are UTC. A file that is damaged or not the bench's own is named and left alone.
    """
    from harness.cli.terminal import show_tables
    from harness.history.store import open_history
    from harness.output import check_file
    from harness.tables import Table

    if history is None:
        raise InputError("history", "none", "a folder to read runs from")
    if sql is not None and (as_rows or any(given.values())):
        raise InputError("sql", sql, "no filter beside it: it has a WHERE of its own")
    if export is not None and Path(export).suffix not in FORMATS:
        raise InputError("export", export, f"a file that ends in one of {', '.join(FORMATS)}")
    target = None if export is None else check_file(export, "export")
    where = _where(given)
    title, most, usual = "Runs", None, _RUNS.format(where=where)
    if sql is not None or as_rows:
        title, most, usual = "Rows", SHOWN, f"SELECT {_BRIEF} FROM rows {where}"
    if target is not None:  # not sorted: for that, millions of rows would all be in memory
        usual = f"SELECT * FROM rows {where}"
    past = open_history(history)
    notes = [f"skipped {path}: {why}" for path, why in past.skipped]
    found = past.query(usual if sql is None else sql)
    if target is not None:
        click.echo(f"wrote {target}: {found.write(target)} rows")
        for note in notes:
            click.echo(f"rps-bench: {note}", err=True)
        return 0
    cells = tuple(tuple(map(_cell, row.values())) for row in found.rows(most))
    more = len(found) - len(cells) if len(cells) == most else 0
    if more:
        notes = [f"{more} more rows; --export FILE writes them all", *notes]
    if not cells:
        notes = [f"no {title.lower()} found in {history}/", *notes]
    show_tables(Table(title, tuple(found.columns), cells, tuple(notes)))
    return 0


def _where(given: dict[str, str | None]) -> str:
    """Return the WHERE clause of the filters as typed; what was left out is None."""
    from harness.history.duck import listed, quoted
    from harness.text import MOST_MODES, numbers, split

    parts: list[str] = []
    for name, text in given.items():
        if text is None:
            continue
        if name == "run":
            said = _LATEST if text == "latest" else quoted(text)
        elif name == "since":
            said = quoted(_utc(text))
        elif name == "mode":
            said = listed(numbers(name, text, MOST_MODES))
        else:
            said = listed(split(name, text))
        parts.append(_FILTERS[name].format(said))
    return "WHERE " + " AND ".join(parts) if parts else ""


def _utc(text: str) -> str:
    try:
        time = datetime.fromisoformat(text)
    except ValueError:
        raise InputError("since", text, "a date as in 2026-01-31, or 2026-01-31T12:00") from None
    return str(time.astimezone(UTC).replace(tzinfo=None) if time.tzinfo else time)


def _cell(value: Any) -> "Cell":
    from harness.tables import Number

    if isinstance(value, float):
        # Three decimals suit a frequency, not a joint's gap or a solver's second.
        return Number(value) if abs(value) >= 1 else f"{value:.3g}" if value else 0
    return value if isinstance(value, int) else "" if value is None else str(value)
