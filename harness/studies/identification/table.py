"""A table of natural frequencies to be explained: the paper's own, or one from a file."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from math import sqrt
from pathlib import Path

import numpy as np

from analytic import InputError
from harness.case import Case
from harness.cases import PRESETS
from harness.signatures import Array

COLUMNS = "rows under the columns case, f1, f2, ..."


@dataclass(frozen=True)
class FrequencyTable:
    """Frequencies [Hz] of the same modes in several cases, as printed.

    Attributes: `source` in words; the `cases` and their poses; `frequencies` (cases, modes);
    `step`, one unit of the last digit printed, (cases, modes).
    """

    source: str
    cases: tuple[Case, ...]
    frequencies: Array
    step: Array

    @property
    def logarithms(self) -> Array:
        """ln f, shape (cases * modes,)."""
        return np.log(self.frequencies).ravel()

    @property
    def weights(self) -> Array:
        """What each value counts, (cases * modes,).

        Two neighbours printed alike, to one unit of the last digit, are one repeated mode of a
        symmetrical pose and say one thing: together they count as one value.
        """
        f = self.frequencies
        twins = np.diff(f, axis=1) <= 1.001 * self.step[:, 1:]
        group = np.insert(np.cumsum(~twins, axis=1), 0, 0, axis=1)
        sizes: Array = (group[:, :, None] == group[:, None, :]).sum(axis=2, dtype=float)
        return 1 / sizes.ravel()

    @property
    def count(self) -> int:
        """How many different values there are."""
        return round(float(self.weights.sum()))

    @property
    def rounding(self) -> float:
        """The relative standard deviation that rounding alone gives a value."""
        return sqrt(np.mean((self.step / self.frequencies) ** 2) / 12)


def published_table(method: str, cases: Sequence[Case]) -> FrequencyTable:
    """Return what the cases' papers print by `method`, or by their only one: modes 1, 2, ...

    Raises `InputError` for another method, and for cases that no paper prints.
    """
    for case in cases:
        if not case.printed:
            raise InputError("table", "published", f"a CSV file with frequencies of {case.name}")
    known = list(dict.fromkeys(one.method for case in cases for one in case.printed))
    chosen = known[0] if len(known) == 1 else method
    if chosen not in known:
        raise InputError("method", method, f"one of {', '.join(known)}")
    ordered = [sorted(case.printed, key=lambda p: p.mode) for case in cases]
    rows = [[p for p in row if p.method == chosen] for row in ordered]
    count = min(map(len, rows))
    for case, row in zip(cases, rows, strict=True):
        if not count or [p.mode for p in row[:count]] != list(range(1, count + 1)):
            expected = "modes from 1 on, none left out, of every case"
            raise InputError("table", case.name, expected)
    values = np.array([[(p.frequency, 2 * p.half) for p in row[:count]] for row in rows])
    papers = dict.fromkeys(case.paper.called or case.paper.name for case in cases if case.paper)
    source = f"{', '.join(papers)}, row {chosen}"
    return FrequencyTable(source, tuple(cases), values[..., 0], values[..., 1])


def read_table(path: Path, method: str | None, cases: Sequence[Case]) -> FrequencyTable:
    """Return the table in a CSV file with columns case, f1, f2, ... [Hz], and perhaps method.

    `method` chooses rows where a case has several; cases are this bench's own or of `cases`.
    Raises `InputError` naming what is wrong.
    """
    columns, *lines = _lines(path)
    rows = [dict(zip(columns, line, strict=True)) for line in lines]
    modes = [f"f{i}" for i in range(1, len(columns) + 1) if f"f{i}" in columns]
    if "case" not in columns or not modes or modes[-1] != f"f{len(modes)}":
        raise InputError("table", str(path), COLUMNS)
    if method is not None:
        known = list(dict.fromkeys(row.get("method", "") for row in rows))
        if method not in known:
            raise InputError("method", method, f"one of {', '.join(known)} in {path}")
        rows = [row for row in rows if row["method"] == method]
    by_name = PRESETS | {case.name: case for case in cases}
    names = [row["case"] for row in rows]
    for name in names:
        if name not in by_name:
            raise InputError("table", name, f"one of the cases {', '.join(by_name)}")
    if len(set(names)) < len(names):
        raise InputError("table", str(path), "one row a case; choose with --method")
    values = [[_frequency(row, mode, path) for mode in modes] for row in rows]
    f = np.array(values, dtype=float)
    if (np.diff(f, axis=1) < 0).any():
        raise InputError("table", str(path), "frequencies that ascend from f1")
    # One unit of the last digit, by the text: 0.1 of "115.0", 10 of "1.1e2".
    step = np.array([[10.0 ** int(one.as_tuple().exponent) for one in row] for row in values])
    source = str(path) if method is None else f"{path}, {method}"
    return FrequencyTable(source, tuple(by_name[name] for name in names), f, step)


def _lines(path: Path) -> list[list[str]]:
    """Return the lines of a CSV file, each with one value a column."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            lines = csv.reader(file, strict=True)
            rows = [[cell.strip() for cell in line] for line in lines if line]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or str(error)
        expected = f"'published' or a readable CSV ({reason})"
        raise InputError("table", str(path), expected) from None
    if len(rows) < 2:
        raise InputError("table", str(path), COLUMNS)
    for name in rows[0]:
        if rows[0].count(name) > 1:
            expected = f"one column {name!r}, not {rows[0].count(name)}"
            raise InputError("table", str(path), expected)
    for row in rows:
        if len(row) != len(rows[0]):
            expected = f"{len(rows[0])} values a row, as many as columns, not {len(row)}"
            raise InputError("table", ",".join(row), expected)
    return rows


def _frequency(row: dict[str, str], mode: str, path: Path) -> Decimal:
    try:
        value = Decimal(row[mode])
    except InvalidOperation:
        value = Decimal(0)
    if not (value.is_finite() and value > 0):
        where = f"{mode} of {row['case']} in {path}"
        raise InputError(where, row[mode], "a positive number of hertz")
    return value
