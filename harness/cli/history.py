"""`rps-bench history`: the runs so far: listed, filtered, asked in SQL, exported."""

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from analytic import InputError
from harness.cli import flags

if TYPE_CHECKING:
    from harness.history.store import Answer
    from harness.tables import Cell, Table

SHOWN = 200
"""Rows a terminal shows; --export has them all."""
FORMATS = (".csv", ".parquet", ".json")
_RUNS = """
SELECT run, time, any_value(command) AS command, any_value(commit) AS commit,
  any_value(release) AS release, count(*) AS rows,
  concat_ws(', ', any_value('python ' || python), any_value('numpy ' || numpy),
    any_value('scipy ' || scipy),
    string_agg(DISTINCT version, ', ' ORDER BY version)
      FILTER (NOT regexp_matches(version, '^(rps-bench|numpy)'))) AS versions
FROM rows {where} GROUP BY run, time ORDER BY time, run
"""
_BRIEF = (
    'run, "case", model, settings, mode, frequency_hz, uncertainty_hz, assurance, closure_m, dofs, '
    "build_s, solve_s, version"
)


@dataclass(frozen=True)
class Wanted:
    """The filters as typed; what was left out is None."""

    run: str | None
    since: str | None
    command: str | None
    model: str | None
    case: str | None
    mode: str | None

    def where(self) -> str:
        """Return the WHERE clause."""
        from harness.history.duck import quoted
        from harness.text import MOST_MODES, numbers, split

        def one_of(column: str, argument: str, text: str) -> str:
            return f"{column} IN ({', '.join(map(quoted, split(argument, text)))})"

        parts: list[str] = []
        if self.run == "latest":
            parts.append("run = (SELECT max_by(run, time) FROM rows)")
        elif self.run is not None:
            parts.append(f"starts_with(run, {quoted(self.run)})")
        if self.since is not None:
            parts.append(f"time >= {quoted(_utc(self.since))}::TIMESTAMP")
        if self.command is not None:
            parts.append(one_of("split_part(command, ' ', 2)", "command", self.command))
        if self.model is not None:  # a bare name is that model with any elements
            named = (one_of(c, "model", self.model) for c in ("model", "split_part(model, '@', 1)"))
            parts.append(f"({' OR '.join(named)})")
        if self.case is not None:
            parts.append(one_of('"case"', "case", self.case))
        if self.mode is not None:
            parts.append(f"mode IN ({str(numbers('mode', self.mode, MOST_MODES))[1:-1]})")
        return "WHERE " + " AND ".join(parts) if parts else ""


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

    if history is None:
        raise InputError("history", "none", "a folder to read runs from")
    if sql is not None and (as_rows or any(given.values())):
        raise InputError("sql", sql, "no filter beside it: it has a WHERE of its own")
    target = _target(export)
    where = Wanted(**given).where()
    past = open_history(history)
    notes = [f"skipped {path}: {why}" for path, why in past.skipped]
    if target is not None:
        # Not sorted: for that, millions of rows would all be in memory.
        height = past.query(f"SELECT * FROM rows {where}" if sql is None else sql).write(target)
        click.echo(f"wrote {target}: {height} rows")
        for note in notes:
            click.echo(f"rps-bench: {note}", err=True)
    elif sql is not None or as_rows:
        asked = f"SELECT {_BRIEF} FROM rows {where}" if sql is None else sql
        show_tables(_table(past.query(asked), history, notes))
    else:
        show_tables(_runs(past.query(_RUNS.format(where=where)), history, notes))
    return 0


def _utc(text: str) -> str:
    try:
        time = datetime.fromisoformat(text)
    except ValueError:
        raise InputError("since", text, "a date as in 2026-01-31, or 2026-01-31T12:00") from None
    return str(time.astimezone(UTC).replace(tzinfo=None) if time.tzinfo else time)


def _target(text: str | None) -> Path | None:
    from harness.output import check_file

    if text is None:
        return None
    if Path(text).suffix not in FORMATS:
        raise InputError("export", text, f"a file that ends in one of {', '.join(FORMATS)}")
    return check_file(text, "export")


def _runs(found: "Answer", folder: Path, notes: list[str]) -> "Table":
    from harness.tables import Table

    columns = ("Run", "Time (UTC)", "Command", "Commit", "Release", "Rows", "Versions")
    rows: list[tuple[Cell, ...]] = [
        (
            row["run"], f"{row['time']:%Y-%m-%d %H:%M:%S}",
            (row["command"] or "").removeprefix("rps-bench "),
            _short(row["commit"] or ""), row["release"] or "", row["rows"], row["versions"],
        )
        for row in found.rows()
    ]  # fmt: skip
    if not rows:
        notes = [f"no runs found in {folder}/", *notes]
    return Table("Runs", columns, tuple(rows), tuple(notes))


def _short(commit: str) -> str:
    revision, dash, dirty = commit.partition("-")
    return revision[:12] + dash + dirty


def _table(found: "Answer", folder: Path, notes: list[str]) -> "Table":
    """Return the first `SHOWN` rows as a table."""
    from harness.tables import Table

    cells = tuple(tuple(map(_cell, row.values())) for row in found.rows(SHOWN))
    height = len(found) if len(cells) == SHOWN else len(cells)
    if height > SHOWN:
        notes = [f"{height - SHOWN} more rows; --export FILE writes them all", *notes]
    if not cells:
        notes = [f"no rows found in {folder}/", *notes]
    return Table("Rows", tuple(found.columns), cells, tuple(notes))


def _cell(value: Any) -> "Cell":
    from harness.tables import Number

    if isinstance(value, float):
        # Three decimals suit a frequency, not a joint's gap or a solver's second.
        return Number(value) if abs(value) >= 1 else f"{value:.3g}" if value else 0
    return value if isinstance(value, int) else "" if value is None else str(value)
