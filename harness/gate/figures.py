"""What a check compares: its figures, and one row for each of them with its verdict.

Accepted figures are text files, sorted, one line a figure, so that a change shows in a diff. They
are compared digit by digit, so that anything but finite numbers is refused.
"""

import csv
import io
import math
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from analytic import InputError, Modes
from analytic.pairing import Pairing
from harness.bench import label
from harness.gate.plan import MODES, group
from harness.output import write_all
from harness.signatures import Array
from reference_models import Named, parse

Key = tuple[str, str, int]
"""Case (or pose of the map), model's label, mode from 1. Orders: model's name."""
Place = tuple[str, str]
FACTOR = 10
"""Noise is the largest of four deviations; ten times it leaves room for other processors."""
ORDER = 0.02
"""Least tolerance of an observed order."""
BAND = 1e-3
"""Least tolerance of a stated uncertainty, relative."""


class Shaped(NamedTuple):
    """One mode: its `frequency` [Hz], the `partner` it looks like among the anchor's modes (from
    1) and their `assurance`.
    """

    frequency: float
    partner: int
    assurance: float


class Count(NamedTuple):
    """How many modes, a `number`, lie below `cut` [Hz]."""

    cut: float
    number: int


class Order(NamedTuple):
    """An observed order `p`, the `formal` one, and the `elements` a limb of the meshes."""

    p: float
    formal: float
    elements: tuple[int, ...]

    def labels(self, name: str) -> list[str]:
        """Return what the meshes of the model called `name` are called."""
        return [label(Named(name, n)) for n in self.elements]


class Source(NamedTuple):
    """What a model assumes, and the program behind it."""

    theory: str
    version: str


class Limit(NamedTuple):
    """The measured `noise` of a frequency and the `tolerance` of its changes, relative."""

    noise: float
    tolerance: float


class Reason(NamedTuple):
    """Why something was accepted that lowers the bar: kept for good."""

    time: str
    commit: str
    quantity: str
    model: str
    case: str
    mode: int
    before: str
    after: str
    reason: str


@dataclass(frozen=True)
class Figures:
    """Everything that is compared, by where it belongs.

    Attributes: `modes`, `uncertainties` [Hz] of models that state them, `counts`, `orders`;
    `sources` by label; `mechanisms`, their hashes, by case. Where they were accepted: `limits`, all
    map poses as one case; `timed_since`, by model, the first run whose seconds count; `reasons`.
    Where they were just measured: `answers` by place: the modes, their pairing with the anchor's,
    and the anchor's with them.
    """

    modes: dict[Key, Shaped] = field(default_factory=dict)
    uncertainties: dict[Key, float] = field(default_factory=dict)
    counts: dict[Place, Count] = field(default_factory=dict)
    orders: dict[Key, Order] = field(default_factory=dict)
    sources: dict[str, Source] = field(default_factory=dict)
    mechanisms: dict[str, str] = field(default_factory=dict)
    limits: dict[Key, Limit] = field(default_factory=dict)
    timed_since: dict[str, str] = field(default_factory=dict)
    reasons: tuple[Reason, ...] = ()
    answers: dict[Place, tuple[Modes, Pairing, Pairing]] = field(default_factory=dict)

    @property
    def simulators(self) -> set[str]:
        """Names of the simulators that there are figures of; not of models that are gone."""
        found = set()
        for model in self.sources:
            with suppress(InputError):
                named = parse(model, "baseline")
                found |= {named.name} if named.info().isolated else set()
        return found

    def updated(self, newer: "Figures", gone: Collection[str] = ()) -> "Figures":
        """Return these figures with those of `newer` in their place, without models `gone`.

        A model measured again leaves nothing old behind.
        """
        left = {*gone, *newer.sources}

        def kept(key: Any, one: Any) -> bool:
            model = key if isinstance(key, str) else key[1]
            return left.isdisjoint(one.labels(model) if isinstance(one, Order) else [model])

        return replace(self, **{
            name: {key: one for key, one in getattr(self, name).items() if kept(key, one)}
            | getattr(newer, name)
            for name in ("modes", "uncertainties", "counts", "orders", "sources", "mechanisms")
        })  # fmt: skip

    def followed(self, case: str, labels: Sequence[str], mode: int) -> Array:
        """Return the frequency [Hz] of `mode` of the last of `labels` in each of them.

        It is followed by its shape; where a coarse mesh has no such mode among those compared, by
        its number.
        """
        partner = self.modes[case, labels[-1], mode].partner
        found = []
        for one in labels:
            numbered = (self.modes.get((case, one, i)) for i in range(1, MODES + 1))
            alike = (shaped for shaped in numbered if shaped and shaped.partner == partner)
            found.append((next(alike, None) or self.modes[case, one, mode]).frequency)
        return np.array(found)

    def tolerance(self, key: Key) -> float:
        """Return the tolerance of a frequency, relative."""
        case, model, mode = key
        return self.limits[group(case), model, mode].tolerance

    def order_tolerance(self, key: Key) -> float:
        """Return the tolerance of an observed order: that of the frequencies, carried through.

        p = ln((f_2 - f_1) / (f_3 - f_2)) / ln r, so |dp| <= (2 d / |f_2 - f_1| + 2 d /
        |f_3 - f_2|) / ln r with d the largest error of a frequency.
        """
        case, name, mode = key
        order = self.orders[key]
        labels = order.labels(name)
        values = self.followed(case, labels, mode)
        d = max(self.tolerance((case, one, mode)) for one in labels) * values[-1]
        ratio = order.elements[-1] / order.elements[-2]
        return max(ORDER, float((2 * d / np.abs(np.diff(values))).sum() / np.log(ratio)))

    def band_tolerance(self, key: Key) -> float:
        """Return the tolerance of a stated uncertainty, relative: it is a difference of two."""
        stated, frequency = self.uncertainties[key], self.modes[key].frequency
        return max(BAND, FACTOR * self.tolerance(key) * frequency / max(stated, 1e-300))


FILES: dict[str, tuple[str, Callable[..., Any], int, str]] = {
    "frequencies.csv": ("modes", Shaped, 3,
                        "case model mode:d frequency_hz:r partner:d assurance:.6f"),
    "uncertainties.csv": ("uncertainties", float, 3, "case model mode:d uncertainty_hz:r"),
    "tolerances.csv": ("limits", Limit, 3, "case model mode:d noise:.3g tolerance:.3g"),
    "counts.csv": ("counts", Count, 2, "case model cut_hz:.6g modes_below:d"),
    "orders.csv": ("orders", Order, 3, "case model mode:d order:.6f formal:g elements:list"),
    "models.csv": ("sources", Source, 1, "model theory version"),
    "mechanisms.csv": ("mechanisms", str, 1, "case mechanism"),
    "timings.csv": ("timed_since", str, 1, "model since"),
    "reasons.csv": ("reasons", Reason, 0,
                    "time commit quantity model case mode:d before after reason"),
}  # fmt: skip
"""Every file: the figures that it holds, what one is, how many columns are its key, and all columns
with their forms; "r" is a number with every digit."""


def save(folder: Path, figures: Figures) -> list[Path]:
    """Write accepted figures into `folder`, all files or none."""
    files = {}
    for file, (name, _, keys, columns) in FILES.items():
        held, text = getattr(figures, name), io.StringIO()
        names, forms = zip(*_columns(columns), strict=True)
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(names)
        for row in [_cells(k) + _cells(one) for k, one in sorted(held.items())] if keys else held:
            writer.writerow(map(_written, forms, row))
        files[file] = text.getvalue().encode()
    return write_all(folder, files, "baseline")


def load(folder: Path) -> Figures | None:
    """Return the accepted figures in `folder`; None where there is none.

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
            forms = dict(_columns(columns))
            if reader.fieldnames != [*forms]:
                raise ValueError(f"{file}: other columns")
            rows = [[_read(form, name, row) for name, form in forms.items()] for row in reader]
            ones = [kind(*row[keys:]) for row in rows]
            at = [row[0] if keys == 1 else tuple(row[:keys]) for row in rows]
            held[name] = dict(zip(at, ones, strict=True)) if keys else tuple(ones)
        figures = Figures(**held)
        for (case, model, mode), order in figures.orders.items():
            figures.followed(case, order.labels(model), mode)  # refuses one of no frequencies
        return figures
    except OSError as error:
        why = f"{file}: {error.strerror or error}"
    except (ValueError, KeyError, TypeError, InputError) as error:
        why = str(error)
    raise InputError("baseline", str(folder), f"a folder written by rps-bench accept ({why})")


def _columns(columns: str) -> list[tuple[str, str]]:
    return [(name, form) for name, _, form in (one.partition(":") for one in columns.split())]


def _cells(one: Any) -> tuple[Any, ...]:
    return one if isinstance(one, tuple) else (one,)


def _written(form: str, value: Any) -> str:
    if form == "list":
        return " ".join(map(str, value))
    return repr(value) if form == "r" else format(value, form)


def _read(form: str, column: str, row: dict[str, str]) -> Any:
    text = row[column]
    if form == "list":
        return tuple(map(int, text.split()))
    if form in ("", "d"):
        return int(text) if form else text
    value = float(text)
    if not math.isfinite(value) or value < 0 or (column == "tolerance" and value == 0):
        raise ValueError(f"{column} of {row['model']} at {row['case']} is {text}")
    return value


HELD, FAILED, BETTER, NOTED = "held", "failed", "better", "noted"
"""`BETTER` fails as well (a two-way ratchet), but is accepted without a reason."""
COMPARED = ("frequency", "uncertainty", "shape", "mode count", "order", "property", "timing")
"""Kinds of which there is a row for everything that was looked at, and not only for what fails."""
KINDS = (*COMPARED[:5], "missing", *COMPARED[5:], "failure", "source")
"""Every kind of row, in the order in which tables show them."""
RELATIVE = ("frequency", "uncertainty", "timing")
"""Kinds whose changes are relative."""


@dataclass(frozen=True)
class Finding:
    """One thing that is as it was, or as it must be, or not.

    Attributes: `kind`, one of `KINDS`; `model`, `case`, `mode` (from 1; None where it concerns
    all); `quantity`; its value `before` and `after`; `tolerance`, the change allowed; `verdict`;
    `cause`, as far as it can be seen. Of a property `quantity` is its name, `after` the relative
    deviation where it is worst, `tolerance` the bound, and `cause` what the bound comes from.
    """

    kind: str
    model: str
    case: str
    mode: int | None
    quantity: str
    before: float | str | None = None
    after: float | str | None = None
    tolerance: float | None = None
    verdict: str = FAILED
    cause: str = ""

    @property
    def fails(self) -> bool:
        """Whether it makes the check fail."""
        return self.verdict in (FAILED, BETTER)

    @property
    def moved(self) -> float | None:
        """The change: relative for frequencies and seconds, else the difference."""
        if not (isinstance(self.before, float) and isinstance(self.after, float)):
            return None
        change = self.after - self.before
        if self.kind not in RELATIVE or not change:
            return change
        return self.after / self.before - 1 if self.before else np.inf


def condense(findings: Sequence[Finding]) -> list[tuple[Finding, str, int]]:
    """Return what a table shows: of the map's poses each model's worst; where; how many it is of.

    Worst: the largest change over its tolerance; what has no such change is worst of all.
    """

    def excess(one: Finding) -> float:
        return abs(one.moved) / one.tolerance if one.moved is not None and one.tolerance else np.inf

    shown = [(one, one.case, 1) for one in findings if group(one.case) == one.case]
    groups: dict[tuple[str, str, str], list[Finding]] = {}
    for one in findings:
        if group(one.case) != one.case:
            groups.setdefault((one.kind, one.model, one.verdict), []).append(one)
    for poses in groups.values():
        worst, of = max(poses, key=excess), len(poses)
        shown.append((worst, worst.case if of == 1 else f"{worst.case} (worst of {of})", of))
    return shown
