"""What the paper prints, and what is wrong with it: data under results/published."""

import csv
import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path

_HERE = Path(__file__).parent
# A wheel carries the data inside the package; a checkout has it under results/.
_FOLDERS = (_HERE / "published_data", _HERE.parent / "results" / "published")


@dataclass(frozen=True)
class Erratum:
    """One statement of the paper that cannot be taken as printed."""

    id: str
    where: str
    statement: str
    reading: str
    evidence: str
    command: str


def text(name: str) -> str:
    """Return a file of results/published."""
    folder = next(folder for folder in _FOLDERS if folder.is_dir())
    return (folder / name).read_text(encoding="utf-8")


@cache
def table1() -> dict[tuple[str, str], tuple[float, ...]]:
    """Return Table I: (case, "FEA" | "Theoretical" | "Error (%)") to f1..f6 [Hz or %]."""
    rows = csv.DictReader(text("table1.csv").splitlines())
    return {
        (row["case"], row["method"]): tuple(float(row[f"f{i}"]) for i in range(1, 7))
        for row in rows
    }


@cache
def figure3() -> dict[tuple[str, int, int], float]:
    """Return the errors quoted for Fig. 3: (case, elements, mode) to percent."""
    rows = csv.DictReader(text("fig3.csv").splitlines())
    return {
        (row["case"], int(row["elements"]), int(row["mode"])): float(row["error_percent"])
        for row in rows
    }


@cache
def cost() -> dict[str, float]:
    """Return what the paper says its model costs: quantity to seconds, or percent saved."""
    rows = csv.DictReader(text("cost.csv").splitlines())
    return {row["quantity"]: float(row["value"]) for row in rows}


@cache
def errata() -> tuple[Erratum, ...]:
    """Return the errata list, in the order of the file."""
    return tuple(Erratum(**entry) for entry in tomllib.loads(text("errata.toml"))["erratum"])


@cache
def paper() -> dict[str, str]:
    """Return what the paper is: authors, title, journal, when it was published, and its address."""
    return tomllib.loads(text("paper.toml"))
