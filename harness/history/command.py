"""`rps-bench history`: the runs so far: listed, filtered, asked in SQL, exported."""

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from analytic import InputError
from harness.history_option import takes_history
from harness.options import MOST_MODES, numbers, split

if TYPE_CHECKING:
    import polars as pl

    from harness.history.store import History
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
_ROWS = "SELECT * FROM rows {where}"
"""Not sorted: for that, millions of rows would all be in memory, and they come in a good order."""
_BRIEF = (
    "run", "case", "model", "settings", "mode", "frequency_hz", "uncertainty_hz", "assurance",
    "closure_m", "dofs", "build_s", "solve_s", "version",
)  # fmt: skip


@dataclass(frozen=True)
class Wanted:
    """The filters as typed; what was left out is None."""

    run: str | None
    since: str | None
    command: str | None
    model: str | None
    case: str | None
    mode: str | None

    def where(self) -> tuple[str, dict[str, Any]]:
        """Return the WHERE clause and what its names stand for."""
        parts: list[str] = []
        values: dict[str, Any] = {}
        if self.run == "latest":
            parts.append("run = (SELECT max_by(run, time) FROM rows)")
        elif self.run is not None:
            parts.append("starts_with(run, $run)")
            values["run"] = self.run
        if self.since is not None:
            parts.append("time >= $since::TIMESTAMP")
            values["since"] = _utc(self.since)
        if self.command is not None:
            parts.append("list_contains($command, split_part(command, ' ', 2))")
            values["command"] = split("--command", self.command)
        if self.model is not None:
            # A bare name is that model with any elements.
            named = (
                "list_contains($model, model) OR list_contains($model, split_part(model, '@', 1))"
            )
            parts.append(f"({named})")
            values["model"] = split("--model", self.model)
        if self.case is not None:
            parts.append('list_contains($case, "case")')
            values["case"] = split("--case", self.case)
        if self.mode is not None:
            parts.append("list_contains($mode, mode)")
            values["mode"] = numbers("--mode", self.mode, MOST_MODES)
        return ("WHERE " + " AND ".join(parts) if parts else ""), values


@click.command()
@click.option("--run", metavar="RUN", help="One run, by the start of its name, or latest.")
@click.option("--since", metavar="DATE", help="Runs from then on, as in 2026-01-31 or with a time.")
@click.option("--command", metavar="A,B", help="Runs of these commands, such as table,check.")
@click.option("--model", metavar="A,B", help="These models: NAME, or NAME@ELEMENTS.")
@click.option("--case", metavar="CASE,CASE", help="These cases.")
@click.option("--mode", metavar="I,I", help="These mode numbers.")
@click.option("--rows", "as_rows", is_flag=True, help="Show the rows, not the runs.")
@click.option("--sql", metavar="SELECT", help='Any query, as in "SELECT max(dofs) FROM rows".')
@click.option("--export", metavar="FILE", help="Write all rows found: .csv, .parquet or .json.")
@takes_history
def history(
    history: Path | None, as_rows: bool, sql: str | None, export: str | None, **given: str | None
) -> int:
    """List the runs so far; filter them, show their rows, or export these.

    Times are UTC. A file that is damaged or not the bench's own is named and left alone.
    """
    from harness.history.store import open_history
    from harness.terminal import show

    if history is None:
        raise InputError("--history", "none", "a folder to read runs from")
    if sql is not None and (as_rows or any(given.values())):
        raise InputError("--sql", sql, "no filter beside it: it has a WHERE of its own")
    target = _target(export)
    where, values = Wanted(**given).where()
    asked = _ROWS.format(where=where) if sql is None else sql
    past = open_history(history)
    notes = [f"skipped {path}: {why}" for path, why in past.skipped]
    if target is not None:
        height = _export(past, asked, values, target)
        click.echo(f"wrote {target}: {height} rows")
        for note in notes:
            click.echo(f"rps-bench: {note}", err=True)
    elif sql is not None:
        show(_table(*past.first(asked, values, SHOWN), history, notes))
    elif as_rows:
        found, height = past.first(asked, values, SHOWN)
        show(_table(found.select(_BRIEF), height, history, notes))
    else:
        show(_runs(past.query(_RUNS.format(where=where), values), history, notes))
    return 0


def _utc(text: str) -> str:
    try:
        time = datetime.fromisoformat(text)
    except ValueError:
        raise InputError("--since", text, "a date as in 2026-01-31, or 2026-01-31T12:00") from None
    return str(time.astimezone(UTC).replace(tzinfo=None) if time.tzinfo else time)


def _target(text: str | None) -> Path | None:
    if text is None:
        return None
    if Path(text).suffix not in FORMATS:
        raise InputError("--export", text, f"a file that ends in one of {', '.join(FORMATS)}")
    return Path(text)


def _export(past: "History", sql: str, values: dict[str, Any], target: Path) -> int:
    """Write the answer and return how many rows it has."""
    from harness.files import staged
    from harness.frames import sink

    _, height = past.first(sql, values, 0)
    with past.scan(sql, values) as table:
        nested = any(kind.is_nested() for kind in table.collect_schema().dtypes())
        if nested and target.suffix == ".csv":
            raise InputError("--export", str(target), "another form (CSV has no lists)")
        with staged(target.parent, [target.name], "--export") as (temporary,):
            sink(table, temporary, target.suffix)
            temporary.replace(target)
    return height


def _runs(found: "pl.DataFrame", folder: Path, notes: list[str]) -> "Table":
    from harness.tables import Table

    columns = ("Run", "Time (UTC)", "Command", "Commit", "Release", "Rows", "Versions")
    rows: list[tuple[Cell, ...]] = [
        (
            row["run"], f"{row['time']:%Y-%m-%d %H:%M:%S}",
            (row["command"] or "").removeprefix("rps-bench "),
            _short(row["commit"] or ""), row["release"] or "", row["rows"], row["versions"],
        )
        for row in found.iter_rows(named=True)
    ]  # fmt: skip
    if not rows:
        notes = [f"no runs found in {folder}/", *notes]
    return Table("Runs", columns, tuple(rows), tuple(notes))


def _short(commit: str) -> str:
    revision, dash, dirty = commit.partition("-")
    return revision[:12] + dash + dirty


def _table(found: "pl.DataFrame", height: int, folder: Path, notes: list[str]) -> "Table":
    """Return the first of `height` rows as a table."""
    from harness.tables import Table

    cells = tuple(tuple(_cell(value) for value in row) for row in found.iter_rows())
    if height > SHOWN:
        notes = [f"{height - SHOWN} more rows; --export FILE writes them all", *notes]
    if found.is_empty():
        notes = [f"no rows found in {folder}/", *notes]
    return Table("Rows", tuple(found.columns), cells, tuple(notes))


def _cell(value: Any) -> "Cell":
    from harness.tables import Number

    if isinstance(value, float):
        # Three decimals suit a frequency, not a joint's gap or a solver's second.
        return Number(value) if abs(value) >= 1 else f"{value:.3g}" if value else 0
    return value if isinstance(value, int) else "" if value is None else str(value)
