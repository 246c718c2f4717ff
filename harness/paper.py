"""A paper as data: one folder is all that table, budget, claims and identify take.

The folder holds `cases.toml` (mechanisms and cases, as in any case file), `table.csv` (case,
method, mode, frequency_hz, where; perhaps error_percent), `paper.toml` (authors, title, source,
year; note, url, called), and where there are any `claims.toml`, `errata.toml`, `fig3.csv` (errors
against elements), `cost.csv` (times) and others that its claims need.
"""

import csv
import math
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, dataclass, field, fields
from decimal import Decimal, InvalidOperation
from functools import cached_property
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Any

from analytic import InputError
from harness.toml_table import Given, read_toml

CHECKED = "gong-lou-2023"
"""The paper that this bench is about."""
CASES, TABLE, ABOUT = "cases.toml", "table.csv", "paper.toml"
COLUMNS = ("case", "method", "mode", "frequency_hz", "where")
KEYS = ("authors", "title", "source", "year")
MORE = ("note", "url", "called")
FORMS = {
    "printed": ("case", "method", "within_percent"),
    "difference": ("case", "method", "against", "at_most_percent"),
}
"""What a claim of any paper can say, and what it must state for it."""
FEA, THEORETICAL, ERROR = TABLE_ONE = ("FEA", "Theoretical", "Error (%)")
"""The rows of Table I: the last is the error of the second against the first."""
_HERE = Path(__file__).parent
# A wheel carries the data inside the package; a checkout has it under results/.
SHIPPED = (_HERE / "published_data", _HERE.parent / "results" / "published")


@dataclass(frozen=True)
class Printed:
    """One frequency as printed: by which `method`, of which `mode` (from 1), [Hz], and `where`.

    `half`: half a unit of its last digit [Hz]; `error`: what is printed as its error [%].
    """

    method: str
    mode: int
    frequency: float
    half: float
    where: str
    error: float | None = None


@dataclass(frozen=True)
class Claim:
    """One statement: what is quoted, how it is checked (`check` with `args`), what shows it."""

    id: str
    section: str
    quoted: str
    how: str
    check: str
    args: Mapping[str, Any]
    command: str
    erratum: str = ""


CLAIM = {one.name for one in fields(Claim)}


@dataclass(frozen=True)
class Erratum:
    """One statement of a paper that cannot be taken as printed, and what is read instead."""

    id: str
    statement: str
    reading: str
    where: str = ""
    evidence: str = ""
    command: str = ""


@dataclass(frozen=True)
class Paper:
    """A published table and what is said of it, each file of its `folder` read when asked for.

    `called`: what sentences call its table, if not by `name`; `table`: what is printed of each
    case, by its name. Everything raises `InputError` naming the file and the key that is wrong.
    """

    folder: Path
    authors: str
    title: str
    source: str
    year: int
    note: str = ""
    url: str = ""
    called: str = ""
    table: Mapping[str, tuple[Printed, ...]] = field(default_factory=dict, compare=False)

    @property
    def name(self) -> str:
        """What its folder is called."""
        return self.folder.resolve().name

    @property
    def citation(self) -> str:
        """The paper in one line."""
        return f"{self.authors}, {self.title}, {self.source}, {self.year}"

    def toml(self, file: str) -> dict[str, Any]:
        """Return what a file of the folder says, nothing where there is none."""
        path = self.folder / file
        return read_toml(path) if path.exists() else {}

    @cached_property
    def errors(self) -> dict[tuple[str, int, int], float]:
        """The errors quoted of few elements: (case, elements, mode) to percent."""
        rows = self._numbers("fig3.csv", case=str, elements=int, mode=int, error_percent=float)
        return {(case, elements, mode): error for case, elements, mode, error in rows}

    @cached_property
    def cost(self) -> dict[str, float]:
        """What the paper says its model costs: quantity to seconds, or percent saved."""
        return dict(self._numbers("cost.csv", quantity=str, value=float))

    def _numbers(self, name: str, **columns: Any) -> list[Any]:
        """Return the rows of a file, each of `columns` as its type; none where there is no file."""
        file = self.folder / name
        try:
            rows = _rows(file) if file.exists() else ()
            return [tuple(kind(row[column]) for column, kind in columns.items()) for row in rows]
        except (KeyError, ValueError, TypeError):
            expected = f"the columns {', '.join(columns)}, with numbers"
            raise InputError(str(file), None, expected) from None

    @cached_property
    def errata(self) -> tuple[Erratum, ...]:
        """What cannot be taken as printed, in the order of the file."""
        entries = self.toml("errata.toml").get("erratum", [])
        return tuple(self._made(Erratum, entry) for entry in entries)

    def _made(self, kind: type[Any], entry: dict[str, Any]) -> Any:
        """Return a claim or an erratum of what it knows of `entry`."""
        for one in fields(kind):
            if one.default is MISSING and one.name not in entry:
                expected = f"the key {one.name!r} in every {kind.__name__.lower()}"
                raise InputError(str(self.folder), None, expected)
        return kind(**{one.name: entry[one.name] for one in fields(kind) if one.name in entry})

    @cached_property
    def claims(self) -> tuple[Claim, ...]:
        """Every claim, in the order of the file; an entry with `over` gives one a combination."""
        file = self.toml("claims.toml")
        return tuple(
            claim for entry in file.get("claim", []) for claim in self._claims(entry, file)
        )

    def _claims(self, entry: dict[str, Any], file: dict[str, Any]) -> Iterator[Claim]:
        """Yield the claims of an entry; its keys but for those of every claim are their args."""
        said = {"command": f"rps-bench claims --case-file {self.name}"}
        said |= {key: value for key, value in entry.items() if key in CLAIM}
        own = {key: value for key, value in entry.items() if key not in (*said, "over")}
        check = said.get("check", "")
        if check in FORMS or "rules" not in file:  # whoever has rules has checks to go with them
            if check and check not in FORMS:
                raise InputError(f"claim {said.get('id')}", check, f"one of {', '.join(FORMS)}")
            for key in FORMS.get(check, ()):
                if key not in own:
                    raise InputError(str(self.folder), None, f"the key {key!r} in every such claim")
            yield self._made(Claim, said | {"args": own})
            return
        over = entry.get("over", {})
        for values in product(*over.values()):
            args = own | dict(zip(over, values, strict=True))
            words = args | {"name": args.get("case", "").replace("case", "Case ")}
            words["printed"] = self.quoted_number(args)
            text = {key: value.format(**words) for key, value in said.items()}
            yield self._made(Claim, text | {"args": MappingProxyType(args)})

    def quoted_number(self, args: Mapping[str, Any]) -> float:
        """Return the number that a claim with `args` quotes; NaN if it quotes none."""
        match args:
            case {"printed": value}:
                return float(value)
            case {"quantity": quantity}:
                return float(self.cost[quantity])
            case {"case": case, "mode": mode, "method": method}:
                return self.row(case, method)[int(mode) - 1]
            case {"case": case, "mode": mode, "from": few, "to": _}:
                return self.errors[case, few, mode] - self.row(case, ERROR)[int(mode) - 1]
            case {"case": case, "mode": mode, "elements": elements}:
                return self.errors[case, elements, mode]
        return math.nan

    def row(self, case: str, method: str) -> tuple[float, ...]:
        """Return what is printed of a case by a method, f1, f2 ... [Hz], or as `ERROR` [%]."""
        some = self.table.get(case, ())
        if method == ERROR:
            return tuple(one.error for one in some if one.error is not None)
        return tuple(one.frequency for one in some if one.method == method)


def shipped() -> dict[str, Path]:
    """Return the papers, each a folder, and the case files that come along, by name."""
    papers = [path.parent for base in SHIPPED for path in base.glob(f"*/{CASES}")]
    files = [path for base in SHIPPED for path in base.glob("*.toml")]
    return {path.stem: path for path in (*papers, *files)[::-1]}


def folder(text: str) -> Path | None:
    """Return the folder of a paper that `text` names: its path, or a name that is shipped."""
    found = shipped().get(text) if not Path(text).is_dir() else Path(text)
    return found if found is not None and found.is_dir() else None


def case_file(path: Path) -> Path:
    """Return `path`, or the case file that comes along if it is the name of one, not a file."""
    return path if path.exists() else shipped().get(str(path), path)


def names() -> list[str]:
    """Return the names of the papers and case files that come along."""
    return sorted(shipped())


def read_paper(path: Path, cases: list[str]) -> Paper:
    """Return the paper of a folder, whose table is of `cases`."""
    file = path / ABOUT
    about = read_toml(file) if file.exists() else {}
    for key in KEYS:
        if key not in about:
            raise InputError(str(file), None, f"the key {key}")
    Given(str(file), about, (*KEYS, *MORE))
    return Paper(path, **about, table=_table(path / TABLE, cases))


def _rows(file: Path) -> "csv.DictReader[str]":
    return csv.DictReader(file.read_text(encoding="utf-8-sig").splitlines())


def _table(file: Path, cases: list[str]) -> dict[str, tuple[Printed, ...]]:
    try:
        reader = _rows(file)
    except OSError as error:
        raise InputError("table", str(file), f"a readable file ({error.strerror})") from None
    if tuple(name for name in reader.fieldnames or () if name != "error_percent") != COLUMNS:
        raise InputError("table", str(file), f"the columns {', '.join(COLUMNS)}")
    found: dict[str, tuple[Printed, ...]] = dict.fromkeys(cases, ())
    for row in reader:
        if row["case"] not in found:
            raise InputError(str(file), row["case"], f"one of the cases {', '.join(cases)}")
        found[row["case"]] += (_printed(row, file),)
    return found


def _printed(row: dict[str, str], file: Path) -> Printed:
    try:
        text = Decimal(row["frequency_hz"])
        mode, value = int(row["mode"]), float(text)
        error = float(row["error_percent"]) if row.get("error_percent") else None
        if not (math.isfinite(value) and value > 0 and mode > 0):
            raise ValueError
    except (InvalidOperation, ValueError, TypeError):
        said = f"{row['mode']}, {row['frequency_hz']}"
        expected = "a mode from 1, and hertz above zero"
        raise InputError(f"{file}, {row['case']}", said, expected) from None
    half = 0.5 * 10.0 ** int(text.as_tuple().exponent)
    return Printed(row["method"], mode, value, half, row["where"], error)
