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
from harness.models import Spec
from harness.report.recorded import MOST_NUMBERS, MOST_POINTS, Recorded, read_recorded
from harness.run import Study, run

TABLES = ("table1", "fig3", "references", "budget", "work-precision", "cheapest", "claims")
CASES = ("case1", "case2")
ELEMENTS = tuple(range(1, 9))


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
    `map`, the accepted workspace map; `claims`; `check`, the gate's last answer or None;
    `recorded`, the history; `skipped`, what was left out and why; `study`, the analytic models at
    the paper's two cases, solved now.
    """

    tables: Mapping[str, TableFile]
    frequencies: pl.DataFrame
    map: pl.DataFrame
    claims: tuple[dict[str, str], ...]
    check: dict[str, Any] | None
    recorded: Recorded
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
    accepted = _map(results / "workspace" / "map.csv", skipped)
    recorded = read_recorded(history, MOST_NUMBERS - _numbers(accepted))
    return Sources(
        tables,
        _frame(results / "frequencies.csv", skipped),
        accepted,
        tuple(claims) if isinstance(claims, list) else (),
        check if isinstance(check, dict) else None,
        recorded,
        (*skipped, *recorded.skipped),
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


def _map(path: Path, skipped: list[tuple[str, str]]) -> pl.DataFrame:
    frame = _frame(path, skipped)
    if _numbers(frame) <= MOST_NUMBERS - MOST_POINTS:
        return frame
    skipped.append((path.name, f"of {frame.height:,} poses: too large for the page"))
    return pl.DataFrame()


def _numbers(accepted: pl.DataFrame) -> int:
    """Return how many frequencies and poses a map has."""
    modes = [name for name in accepted.columns if name.endswith("_hz")]
    return accepted.height * (len(modes) + 1)


@cache
def _solve() -> Study:
    specs = [Spec(name, elements) for name in BEAMS for elements in (*ELEMENTS, None)]
    return run([PRESETS[name] for name in CASES], specs, 6)
