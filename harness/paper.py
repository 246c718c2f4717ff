"""A published table as data: one folder is all that table, budget, claims and identify take.

The folder holds `cases.toml` (mechanisms and cases, as in any case file), `table.csv` (case,
method, mode, frequency_hz, where), `paper.toml` (authors, title, source, year, note), and where
there are any `claims.toml` and `errata.toml`.
"""

import csv
import math
import tomllib
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any

from analytic import InputError

CASES, TABLE, ABOUT = "cases.toml", "table.csv", "paper.toml"
COLUMNS = ("case", "method", "mode", "frequency_hz", "where")
KEYS = ("authors", "title", "source", "year")
CHECKS = {
    "printed": ("case", "method", "within_percent"),
    "difference": ("case", "method", "against", "at_most_percent"),
}
"""What a claim of such a folder can say, and what it must state for it."""
_HERE = Path(__file__).parent
SHIPPED = (_HERE / "published_data", _HERE.parent / "results" / "published")


@dataclass(frozen=True)
class Printed:
    """One frequency as printed: by which `method`, of which `mode` (from 1), [Hz], and `where`.

    `half`: half a unit of its last digit [Hz].
    """

    method: str
    mode: int
    frequency: float
    half: float
    where: str


@dataclass(frozen=True)
class Statement:
    """A claim of a paper: what is `quoted`, `how` it is checked, by which check with `args`."""

    id: str
    section: str
    quoted: str
    how: str
    check: str
    args: tuple[tuple[str, Any], ...]


@dataclass(frozen=True)
class Paper:
    """Where a published table is from: `name` of its folder, bibliography, claims and errata."""

    name: str
    authors: str
    title: str
    source: str
    year: int
    note: str = ""
    claims: tuple[Statement, ...] = ()
    errata: tuple[tuple[str, str, str], ...] = ()
    """By id: what is printed, and what is read instead."""

    @property
    def citation(self) -> str:
        """The paper in one line."""
        return f"{self.authors}, {self.title}, {self.source}, {self.year}"


def folder(text: str) -> Path | None:
    """Return the folder of a paper that `text` names: its path, or a name that is shipped."""
    own = Path(text)
    if own.is_dir():
        return own
    found = [base / text for base in SHIPPED if text and Path(text).name == text]
    return next((one for one in found if (one / CASES).is_file()), None)


def names() -> list[str]:
    """Return the names of the papers that are shipped."""
    return sorted({path.parent.name for base in SHIPPED for path in base.glob(f"*/{CASES}")})


def read_paper(path: Path) -> Paper:
    """Return the paper of a folder; raises `InputError` naming the file and key that is wrong."""
    about = _toml(path / ABOUT)
    for key in KEYS:
        if key not in about:
            raise InputError(str(path / ABOUT), None, f"the key {key}")
    unknown = sorted(about.keys() - {*KEYS, "note"})
    if unknown:
        raise InputError(str(path / ABOUT), unknown[0], f"only the keys {', '.join(KEYS)}, note")
    claims = _toml(path / "claims.toml").get("claim", [])
    errata = _toml(path / "errata.toml").get("erratum", [])
    try:
        return Paper(
            name=path.name,
            **about,
            claims=tuple(_statement(one) for one in claims),
            errata=tuple((one["id"], one["statement"], one["reading"]) for one in errata),
        )
    except KeyError as error:
        raise InputError(str(path), None, f"the key {error} in every claim and erratum") from None


def _statement(entry: dict[str, Any]) -> Statement:
    check = entry["check"]
    if check not in CHECKS:
        raise InputError(f"claim {entry['id']}", check, f"one of {', '.join(CHECKS)}")
    wanted = CHECKS[check]
    args = tuple((key, entry[key]) for key in (*wanted, "model") if key != "model" or key in entry)
    said = {key: entry[key] for key in ("id", "section", "quoted", "how")}
    return Statement(**said, check=check, args=args)


def read_table(path: Path, cases: list[str]) -> dict[str, tuple[Printed, ...]]:
    """Return what is printed of each of `cases`; raises `InputError` naming what is wrong."""
    file = path / TABLE
    try:
        reader = csv.DictReader(file.read_text(encoding="utf-8-sig").splitlines())
    except OSError as error:
        raise InputError("table", str(file), f"a readable file ({error.strerror})") from None
    if tuple(reader.fieldnames or ()) != COLUMNS:
        raise InputError("table", str(file), f"the columns {', '.join(COLUMNS)}")
    found: dict[str, list[Printed]] = {name: [] for name in cases}
    for row in reader:
        if row["case"] not in found:
            raise InputError(str(file), row["case"], f"one of the cases {', '.join(cases)}")
        found[row["case"]].append(_printed(row, file))
    return {name: tuple(some) for name, some in found.items()}


def _printed(row: dict[str, str], file: Path) -> Printed:
    try:
        text = Decimal(row["frequency_hz"])
        mode, value = int(row["mode"]), float(text)
    except (InvalidOperation, ValueError, TypeError):
        text, mode, value = Decimal(0), 0, math.nan
    if not (math.isfinite(value) and value > 0 and mode > 0):
        said = f"{row['mode']}, {row['frequency_hz']}"
        raise InputError(f"{file}, {row['case']}", said, "a mode from 1, and hertz above zero")
    half = 0.5 * 10.0 ** int(text.as_tuple().exponent)
    return Printed(row["method"], mode, value, half, row["where"])


def _toml(file: Path) -> dict[str, Any]:
    if not file.exists():
        return {}
    try:
        return tomllib.loads(file.read_text(encoding="utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(str(file), None, f"a TOML file ({error})") from None
