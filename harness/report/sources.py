"""Everything the page shows, read once: accepted results, history, and the analytic models."""

import csv
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import polars as pl

from analytic import InputError
from analytic.theory import BEAMS
from harness.cases import PRESETS
from harness.history.store import open_history
from harness.models import Spec
from harness.run import Study, run

TABLES = ("table1", "fig3", "references", "budget", "work-precision", "cheapest", "claims")
CASES = ("case1", "case2")
ELEMENTS = tuple(range(1, 9))
WORKSPACE = "workspace"  # the case of the gate's poses over the workspace
ABOUT_RUN = ("command", "commit", "release", "machine", "python", "numpy", "scipy", "blas")


@dataclass(frozen=True)
class TableFile:
    """A table as `rps-bench` wrote it: cells of its CSV, title and notes of its Markdown."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    title: str
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Sources:
    """What the sections are made from.

    Attributes: `tables` by stem, those there are; `frequencies`, tidy rows of the accepted run;
    `map`, the detailed workspace map; `claims`; `check`, the gate's last answer or None; `runs`,
    `points` and `workspace` of the history (one row a run; a case, model and mode; a pose);
    `skipped`, files that could not be read and why; `study`, the analytic models at the paper's
    two cases, solved now.
    """

    tables: Mapping[str, TableFile]
    frequencies: pl.DataFrame
    map: pl.DataFrame
    claims: tuple[dict[str, str], ...]
    check: dict[str, Any] | None
    runs: pl.DataFrame
    points: pl.DataFrame
    workspace: pl.DataFrame
    skipped: tuple[tuple[str, str], ...]
    study: Study


def read_sources(results: Path, history: Path | None) -> Sources:
    """Read the folders `results` and `history` (None: no history).

    Raises `InputError` where `results` holds nothing that the page could show.
    """
    known = [*(f"{stem}.csv" for stem in TABLES), "frequencies.csv", "claims.json", "check.json"]
    if not any((results / name).is_file() for name in known):
        expected = "a folder that `rps-bench reproduce` has written to"
        raise InputError("--results", str(results), expected)
    skipped: list[tuple[str, str]] = []
    tables = {}
    for stem in TABLES:
        if (results / f"{stem}.csv").is_file():
            try:
                tables[stem] = _table(results / stem)
            except (ValueError, csv.Error) as error:
                skipped.append((f"{stem}.csv", str(error)))
    claims = _json(results / "claims.json", skipped)
    check = _json(results / "check.json", skipped)
    runs, points, workspace = _history(history, skipped)
    return Sources(
        tables,
        _frame(results / "frequencies.csv", skipped),
        _frame(results / "workspace" / "map.csv", skipped),
        tuple(claims) if isinstance(claims, list) else (),
        check if isinstance(check, dict) else None,
        runs,
        points,
        workspace,
        tuple(skipped),
        _solve(),
    )


def _table(stem: Path) -> TableFile:
    with stem.with_suffix(".csv").open(newline="", encoding="utf-8") as file:
        columns, *rows = (tuple(row) for row in csv.reader(file, strict=True))
    if any(len(row) != len(columns) for row in rows):
        raise ValueError("its rows are not as long as its header")
    page = stem.with_suffix(".md")
    lines = page.read_text(encoding="utf-8").splitlines() if page.is_file() else []
    title = next((line[3:] for line in lines if line.startswith("## ")), "")
    notes = tuple(line[2:] for line in lines if line.startswith("- "))
    return TableFile(columns, tuple(rows), title, notes)


def _json(path: Path, skipped: list[tuple[str, str]]) -> Any:
    if not path.is_file():
        return None
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        skipped.append((path.name, str(error)))
        return None


def _frame(path: Path, skipped: list[tuple[str, str]]) -> pl.DataFrame:
    if not path.is_file():
        return pl.DataFrame()
    try:
        return pl.read_csv(path, infer_schema_length=None)
    except pl.exceptions.PolarsError as error:
        skipped.append((path.name, str(error).splitlines()[0]))
        return pl.DataFrame()


def _history(
    folder: Path | None, skipped: list[tuple[str, str]]
) -> tuple[pl.DataFrame, pl.DataFrame, pl.DataFrame]:
    """Return the runs in the order of time, their named cases, and their workspace poses."""
    nothing = pl.DataFrame()
    if folder is None:
        return nothing, nothing, nothing
    store = open_history(folder)
    skipped += [(path.name, why) for path, why in store.skipped]
    about = ", ".join(
        f'coalesce(any_value("{name}"), \'not known\') AS "{name}"' for name in ABOUT_RUN
    )
    runs = store.query(
        f"""SELECT run, {about}, min(time) AS time, count(*) AS "rows" FROM rows
        GROUP BY run ORDER BY time, run"""
    )
    points = store.query(
        """SELECT run, "case", mechanism, z_m, azimuth_rad, tilt_rad, model, theory, settings,
        version, mode, frequency_hz, uncertainty_hz, assurance, closure_m, dofs, build_s, solve_s
        FROM rows WHERE "case" IS DISTINCT FROM ?""",
        [WORKSPACE],
    )
    workspace = store.query(
        """SELECT run, mechanism, z_m, azimuth_rad, tilt_rad, model, theory, settings, version,
        mode, frequency_hz FROM rows WHERE "case" = ?""",
        [WORKSPACE],
    )
    return runs, points, workspace


@cache
def _solve() -> Study:
    specs = [Spec(name, elements) for name in BEAMS for elements in (*ELEMENTS, None)]
    return run([PRESETS[name] for name in CASES], specs, 6)
