"""The accepted figures as text files: sorted, one line a figure, so that a change shows in a diff.

What they hold is compared digit by digit, so that anything but finite numbers is refused.
"""

import csv
import io
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar

from analytic import InputError
from harness.bench import label
from harness.gate.measured import Count, Key, Measured, Order, Shaped, Source, followed
from harness.gate.ratchet import Baseline, Reason
from harness.output import write_all
from reference_models import Named

EXPECTED = "a folder written by rps-bench accept"
HEADERS = {
    "frequencies.csv": ("case", "model", "mode", "frequency_hz", "partner", "assurance"),
    "uncertainties.csv": ("case", "model", "mode", "uncertainty_hz"),
    "tolerances.csv": ("case", "model", "mode", "noise", "tolerance"),
    "counts.csv": ("case", "model", "cut_hz", "modes_below"),
    "orders.csv": ("case", "model", "mode", "order", "formal", "elements"),
    "models.csv": ("model", "theory", "version"),
    "mechanisms.csv": ("case", "mechanism"),
    "timings.csv": ("model", "since"),
    "reasons.csv": tuple(f.name for f in fields(Reason)),
}
Row = Mapping[str, str]
T = TypeVar("T")


def save(folder: Path, baseline: Baseline) -> list[Path]:
    """Write the baseline into `folder`, all files or none."""
    now = baseline.figures
    rows: dict[str, Sequence[Sequence[Any]]] = {
        "frequencies.csv": [
            (*key, repr(one.frequency), one.partner, f"{one.assurance:.6f}")
            for key, one in sorted(now.modes.items(), key=_key)
        ],
        "uncertainties.csv": [
            (*key, repr(value)) for key, value in sorted(now.uncertainties.items())
        ],
        "tolerances.csv": [
            (*key, f"{baseline.noise[key]:.3g}", f"{value:.3g}")
            for key, value in sorted(baseline.tolerance.items())
        ],
        "counts.csv": [
            (*key, f"{one.cut:.6g}", one.number)
            for key, one in sorted(now.counts.items(), key=_key)
        ],
        "orders.csv": [
            (*key, f"{one.p:.6f}", f"{one.formal:g}", " ".join(map(str, one.elements)))
            for key, one in sorted(now.orders.items(), key=_key)
        ],
        "models.csv": [
            (key, one.theory, one.version) for key, one in sorted(now.sources.items(), key=_key)
        ],
        "mechanisms.csv": sorted(now.mechanisms.items()),
        "timings.csv": sorted(baseline.timed_since.items()),
        "reasons.csv": [tuple(vars(reason).values()) for reason in baseline.reasons],
    }  # fmt: skip
    return write_all(folder, {name: _csv(rows[name], name) for name in HEADERS}, "baseline")


def _key(item: tuple[Any, Any]) -> Any:
    return item[0]


def _csv(rows: Sequence[Sequence[Any]], name: str) -> bytes:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([HEADERS[name], *rows])
    return text.getvalue().encode()


def load(folder: Path) -> Baseline | None:
    """Return the baseline in `folder`; None where there is none.

    Raises `InputError` for files that are not a whole baseline, or hold anything but finite
    numbers.
    """
    if not folder.exists():
        return None
    rows = {name: _rows(folder, name) for name in HEADERS}
    try:
        return _baseline(rows)
    except (ValueError, KeyError, TypeError, InputError) as error:
        raise InputError("baseline", str(folder), f"{EXPECTED} ({error})") from None


def _rows(folder: Path, name: str) -> list[dict[str, str]]:
    try:
        lines = (folder / name).read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError("baseline", str(folder), f"{EXPECTED} ({name}: {reason})") from None
    reader = csv.DictReader(lines)
    if tuple(reader.fieldnames or ()) != HEADERS[name]:
        raise InputError("baseline", str(folder), f"{EXPECTED} ({name}: other columns)")
    return list(reader)


def _baseline(rows: Mapping[str, Sequence[Row]]) -> Baseline:
    modes = _keyed(
        rows["frequencies.csv"],
        lambda r: Shaped(
            _number(r, "frequency_hz"), int(r["partner"]), _number(r, "assurance")
        ),
    )  # fmt: skip
    figures = Measured(
        modes,
        _keyed(rows["uncertainties.csv"], lambda r: _number(r, "uncertainty_hz")),
        {
            (r["case"], r["model"]): Count(_number(r, "cut_hz"), int(r["modes_below"]))
            for r in rows["counts.csv"]
        },
        _keyed(rows["orders.csv"], lambda r: _order(r, modes)),
        {r["model"]: Source(r["theory"], r["version"]) for r in rows["models.csv"]},
        {r["case"]: r["mechanism"] for r in rows["mechanisms.csv"]},
    )
    return Baseline(
        figures,
        _keyed(rows["tolerances.csv"], lambda r: _number(r, "noise")),
        _keyed(rows["tolerances.csv"], lambda r: _number(r, "tolerance", above=True)),
        {r["model"]: r["since"] for r in rows["timings.csv"]},
        tuple(Reason(**{**r, "mode": int(r["mode"])}) for r in rows["reasons.csv"]),  # type: ignore[arg-type]
    )


def _keyed(rows: Sequence[Row], value: Callable[[Row], T]) -> dict[Key, T]:
    return {(r["case"], r["model"], int(r["mode"])): value(r) for r in rows}


def _number(row: Row, name: str, *, above: bool = False) -> float:
    value = float(row[name])
    if not math.isfinite(value) or value < 0 or (above and value == 0):
        raise ValueError(f"{name} of {row['model']} at {row['case']} is {row[name]}")
    return value


def _order(row: Row, modes: Mapping[Key, Shaped]) -> Order:
    elements = tuple(int(n) for n in row["elements"].split())
    labels = tuple(label(Named(row["model"], n)) for n in elements)
    values = followed(modes, row["case"], labels, int(row["mode"]))
    return Order(_number(row, "order"), elements, values, labels, _number(row, "formal"))
