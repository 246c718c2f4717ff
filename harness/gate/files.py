"""The accepted figures as text files: sorted, one line a figure, so that a change shows in a diff.

What they hold is compared digit by digit, so that anything but finite numbers is refused.
"""

import csv
import io
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from analytic import InputError
from harness.gate.measured import STORED, Count, Measured, Order, Shaped, Source
from harness.gate.ratchet import Baseline, Limit, Reason
from harness.output import write_all

KEY = "case", "model", "mode"
FILES: dict[str, tuple[str, Callable[..., Any], tuple[str, ...], tuple[str, ...]]] = {
    "frequencies.csv": ("modes", Shaped, KEY, ("frequency_hz", "partner", "assurance")),
    "uncertainties.csv": ("uncertainties", float, KEY, ("uncertainty_hz",)),
    "tolerances.csv": ("limits", Limit, KEY, ("noise", "tolerance")),
    "counts.csv": ("counts", Count, KEY[:2], ("cut_hz", "modes_below")),
    "orders.csv": ("orders", Order, KEY, ("order", "formal", "elements")),
    "models.csv": ("sources", Source, ("model",), ("theory", "version")),
    "mechanisms.csv": ("mechanisms", str, ("case",), ("mechanism",)),
    "timings.csv": ("timed_since", str, ("model",), ("since",)),
    "reasons.csv": ("reasons", Reason, (), Reason._fields),
}
"""Every file: the figures that it holds, what one is, the columns of its key, and its own."""
NUMBERS = {
    "frequency_hz": "r", "uncertainty_hz": "r", "assurance": ".6f", "noise": ".3g",
    "tolerance": ".3g", "cut_hz": ".6g", "order": ".6f", "formal": "g",
}  # fmt: skip
"""Columns of numbers, and how these are written; "r": with every digit."""
WHOLE = "mode", "partner", "modes_below"


def save(folder: Path, baseline: Baseline) -> list[Path]:
    """Write the baseline into `folder`, all files or none."""
    held = vars(baseline.figures) | vars(baseline)
    files = {}
    for file, (name, _, keys, columns) in FILES.items():
        figures, text = held[name], io.StringIO()
        rows = [_cells(k) + _cells(one) for k, one in sorted(figures.items())] if keys else figures
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow((*keys, *columns))
        writer.writerows(map(_written, (*keys, *columns), row) for row in rows)
        files[file] = text.getvalue().encode()
    return write_all(folder, files, "baseline")


def load(folder: Path) -> Baseline | None:
    """Return the baseline in `folder`; None where there is none.

    Raises `InputError` for files that are not a whole baseline, or hold anything but finite
    numbers.
    """
    if not folder.exists():
        return None
    held: dict[str, Any] = {}
    file = ""
    try:
        for file, (name, kind, keys, columns) in FILES.items():
            reader = csv.DictReader((folder / file).read_text(encoding="utf-8").splitlines())
            if tuple(reader.fieldnames or ()) != (*keys, *columns):
                raise ValueError(f"{file}: other columns")
            n, rows = len(keys), [[_read(column, row) for column in row] for row in reader]
            ones = [kind(*row[n:]) for row in rows]
            at = [row[0] if n == 1 else tuple(row[:n]) for row in rows]
            held[name] = dict(zip(at, ones, strict=True)) if n else tuple(ones)
        figures = Measured(**{name: held.pop(name) for name in STORED})
        for (case, model, mode), order in figures.orders.items():
            figures.followed(case, order.labels(model), mode)  # refuses one of no frequencies
        return Baseline(figures, **held)
    except OSError as error:
        why = f"{file}: {error.strerror or error}"
    except (ValueError, KeyError, TypeError, InputError) as error:
        why = str(error)
    raise InputError("baseline", str(folder), f"a folder written by rps-bench accept ({why})")


def _cells(one: Any) -> tuple[Any, ...]:
    return one if isinstance(one, tuple) else (one,)


def _written(column: str, value: Any) -> Any:
    if column == "elements":
        return " ".join(map(str, value))
    form = NUMBERS.get(column, "")
    return repr(value) if form == "r" else format(value, form)


def _read(column: str, row: dict[str, str]) -> Any:
    text = row[column]
    if column == "elements":
        return tuple(map(int, text.split()))
    if column not in NUMBERS:
        return int(text) if column in WHOLE else text
    value = float(text)
    if not math.isfinite(value) or value < 0 or (column == "tolerance" and value == 0):
        raise ValueError(f"{column} of {row['model']} at {row['case']} is {text}")
    return value
