"""The accepted figures as text files: sorted, one line a figure, so that a change shows in a diff.

What they hold is compared digit by digit, so that anything but finite numbers is refused.
"""

import csv
import io
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, fields
from operator import itemgetter
from pathlib import Path
from typing import Any, TypeVar

from analytic import InputError
from harness.gate.measured import Count, Key, Measured, Order, Shaped, Source
from harness.gate.ratchet import Baseline, Reason
from harness.output import write_all

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

    def lines(figures: Mapping[Any, T], cells: Callable[[T], Sequence[Any]]) -> list[Any]:
        return [
            (*((key,) if isinstance(key, str) else key), *cells(value))
            for key, value in sorted(figures.items(), key=itemgetter(0))
        ]

    noise = {key: (baseline.noise[key], value) for key, value in baseline.tolerance.items()}
    rows = (
        lines(now.modes, lambda x: (repr(x.frequency), x.partner, f"{x.assurance:.6f}")),
        lines(now.uncertainties, lambda x: [repr(x)]),
        lines(noise, lambda x: [f"{value:.3g}" for value in x]),
        lines(now.counts, lambda x: (f"{x.cut:.6g}", x.number)),
        lines(
            now.orders, lambda x: (f"{x.p:.6f}", f"{x.formal:g}", " ".join(map(str, x.elements)))
        ),
        lines(now.sources, astuple),
        lines(now.mechanisms, lambda x: [x]),
        lines(baseline.timed_since, lambda x: [x]),
        [astuple(reason) for reason in baseline.reasons],
    )
    files = {}
    for (name, header), body in zip(HEADERS.items(), rows, strict=True):
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([header, *body])
        files[name] = text.getvalue().encode()
    return write_all(folder, files, "baseline")


def load(folder: Path) -> Baseline | None:
    """Return the baseline in `folder`; None where there is none.

    Raises `InputError` for files that are not a whole baseline, or hold anything but finite
    numbers.
    """
    if not folder.exists():
        return None
    rows: dict[str, list[Row]] = {}
    name = ""
    try:
        for name, header in HEADERS.items():
            reader = csv.DictReader((folder / name).read_text(encoding="utf-8").splitlines())
            if tuple(reader.fieldnames or ()) != header:
                raise ValueError(f"{name}: other columns")
            rows[name] = list(reader)
        return _baseline(*rows.values())
    except OSError as error:
        why = f"{name}: {error.strerror or error}"
    except (ValueError, KeyError, TypeError, InputError) as error:
        why = str(error)
    raise InputError("baseline", str(folder), f"a folder written by rps-bench accept ({why})")


def _baseline(
    frequencies: list[Row], uncertainties: list[Row], tolerances: list[Row], counts: list[Row],
    orders: list[Row], models: list[Row], mechanisms: list[Row], timings: list[Row],
    reasons: list[Row],
) -> Baseline:  # fmt: skip
    figures = Measured(
        _keyed(frequencies, lambda r: Shaped(
            _number(r, "frequency_hz"), int(r["partner"]), _number(r, "assurance"))),
        _keyed(uncertainties, lambda r: _number(r, "uncertainty_hz")),
        {(r["case"], r["model"]): Count(_number(r, "cut_hz"), int(r["modes_below"]))
         for r in counts},
        _keyed(orders, lambda r: Order(
            _number(r, "order"), tuple(map(int, r["elements"].split())), _number(r, "formal"))),
        {r["model"]: Source(r["theory"], r["version"]) for r in models},
        {r["case"]: r["mechanism"] for r in mechanisms},
    )  # fmt: skip
    for (case, name, mode), order in figures.orders.items():
        figures.followed(case, order.labels(name), mode)  # refuses an order of no frequencies
    return Baseline(
        figures,
        _keyed(tolerances, lambda r: _number(r, "noise")),
        _keyed(tolerances, lambda r: _number(r, "tolerance", above=True)),
        {r["model"]: r["since"] for r in timings},
        tuple(Reason(**{**r, "mode": int(r["mode"])}) for r in reasons),  # type: ignore[arg-type]
    )


def _keyed(rows: Sequence[Row], value: Callable[[Row], T]) -> dict[Key, T]:
    return {(r["case"], r["model"], int(r["mode"])): value(r) for r in rows}


def _number(row: Row, name: str, *, above: bool = False) -> float:
    value = float(row[name])
    if not math.isfinite(value) or value < 0 or (above and value == 0):
        raise ValueError(f"{name} of {row['model']} at {row['case']} is {row[name]}")
    return value
