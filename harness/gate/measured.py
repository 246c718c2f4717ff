"""What a check compares: frequencies, what each mode looks like, mode counts, orders, versions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from analytic import Modes, Substructure
from analytic.pairing import pair
from harness.cases import Case
from harness.gate.study import MODES, Checked
from harness.models import Spec, formal_order
from harness.refinement import verify
from harness.run import GATE, SPARE, Study

Key = tuple[str, str, int]
"""Case (or pose of the map), model's label, mode from 1. Orders: model's name."""
Place = tuple[str, str]
ANCHOR = Substructure(4, "timoshenko")
"""The model whose modes say what a mode looks like: solved anew in every check, never compared."""
APART = 1.001
"""Neighbours this far apart, as a ratio, can be counted between."""


@dataclass(frozen=True)
class Shaped:
    """One mode: its `frequency` [Hz], the `partner` it looks like among the anchor's modes (from
    1) and their `assurance`; `likeness` with every one of the anchor's modes, where just measured.
    """

    frequency: float
    partner: int
    assurance: float
    likeness: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class Count:
    """How many modes lie below `cut` [Hz]; `spectrum`: the frequencies, where just measured."""

    cut: float
    number: int
    spectrum: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class Order:
    """An observed order `p` from `frequencies` [Hz] on `elements` a limb; the `formal` one."""

    p: float
    elements: tuple[int, ...]
    frequencies: tuple[float, ...]
    labels: tuple[str, ...]
    formal: float


@dataclass(frozen=True)
class Source:
    """What a model assumes, and the program behind it."""

    theory: str
    version: str


@dataclass(frozen=True)
class Measured:
    """Everything that is compared, by where it belongs; `found`: by place, the assurance with which
    each of the anchor's modes is among the model's, where just measured.
    """

    modes: dict[Key, Shaped]
    counts: dict[Place, Count]
    orders: dict[Key, Order]
    sources: dict[str, Source]
    mechanisms: dict[str, str]
    found: dict[Place, NDArray[np.float64]] = field(default_factory=dict)

    HEADERS: ClassVar[dict[str, tuple[str, ...]]] = {
        "frequencies.csv": ("case", "model", "mode", "frequency_hz", "partner", "assurance"),
        "counts.csv": ("case", "model", "cut_hz", "modes_below"),
        "orders.csv": ("case", "model", "mode", "order", "formal", "elements"),
        "models.csv": ("model", "theory", "version"),
        "mechanisms.csv": ("case", "mechanism"),
    }

    def updated(self, newer: "Measured") -> "Measured":
        """Return these figures with those of `newer` in their place."""
        gone = set(newer.sources)  # a model measured again leaves nothing old behind
        return Measured(
            {k: v for k, v in self.modes.items() if k[1] not in gone} | newer.modes,
            {k: v for k, v in self.counts.items() if k[1] not in gone} | newer.counts,
            self.orders | newer.orders,
            self.sources | newer.sources,
            self.mechanisms | newer.mechanisms,
        )

    def tables(self) -> dict[str, list[dict[str, Any]]]:
        """Return the rows of the files of `HEADERS`."""
        return {
            "frequencies.csv": [
                {"case": c, "model": m, "mode": i, "frequency_hz": repr(one.frequency),
                 "partner": one.partner, "assurance": f"{one.assurance:.6f}"}
                for (c, m, i), one in sorted(self.modes.items())
            ],
            "counts.csv": [
                {"case": c, "model": m, "cut_hz": f"{one.cut:.6g}", "modes_below": one.number}
                for (c, m), one in sorted(self.counts.items())
            ],
            "orders.csv": [
                {"case": c, "model": m, "mode": i, "order": f"{one.p:.6f}",
                 "formal": f"{one.formal:g}", "elements": " ".join(map(str, one.elements))}
                for (c, m, i), one in sorted(self.orders.items())
            ],
            "models.csv": [
                {"model": m, "theory": one.theory, "version": one.version}
                for m, one in sorted(self.sources.items())
            ],
            "mechanisms.csv": [
                {"case": c, "mechanism": one} for c, one in sorted(self.mechanisms.items())
            ],
        }  # fmt: skip

    @classmethod
    def read(cls, texts: Mapping[str, Sequence[Mapping[str, str]]]) -> "Measured":
        """Return what `tables` wrote. Raises `ValueError` or `KeyError` for anything else."""
        modes = {
            (r["case"], r["model"], int(r["mode"])): Shaped(
                float(r["frequency_hz"]), int(r["partner"]), float(r["assurance"])
            )
            for r in texts["frequencies.csv"]
        }
        orders = {}
        for r in texts["orders.csv"]:
            key = r["case"], r["model"], int(r["mode"])
            elements = tuple(int(n) for n in r["elements"].split())
            labels = tuple(f"{r['model']}@{n}" for n in elements)
            values = followed(modes, r["case"], labels, int(r["mode"]))
            orders[key] = Order(float(r["order"]), elements, values, labels, float(r["formal"]))
        return cls(
            modes,
            {
                (r["case"], r["model"]): Count(float(r["cut_hz"]), int(r["modes_below"]))
                for r in texts["counts.csv"]
            },
            orders,
            {r["model"]: Source(r["theory"], r["version"]) for r in texts["models.csv"]},
            {r["case"]: r["mechanism"] for r in texts["mechanisms.csv"]},
        )


def place(case: Case) -> str:
    """Return what a case is called in findings: a pose of the map by its coordinates."""
    if not case.name.startswith(GATE):
        return case.name
    phi, theta = np.degrees([case.pose.azimuth, case.pose.tilt])
    return f"{GATE} z={1000 * case.pose.z:g} mm, phi={phi:.6g} deg, theta={theta:.4f} deg"


def measure(checked: Checked) -> Measured:
    """Return what a check compares, out of all that was solved."""
    result = Measured({}, {}, {}, {}, {})
    for study in (checked.cases, checked.workspace):
        for case in study.cases if study.specs else ():
            anchor = ANCHOR.modes(case.mechanism, case.pose, study.count + SPARE)
            for spec in study.specs:
                modes = study.get(case, spec)
                if modes is not None:
                    _add(result, study.count, case, spec, modes, anchor)
    for row in checked.rows:
        if "mechanism" in row:
            result.mechanisms[row["case"]] = row["mechanism"]
    for ladder in checked.plan.ladders:
        if len(ladder) >= 3:
            _orders(result, checked.cases, ladder)
    return result


def _add(result: Measured, count: int, case: Case, spec: Spec, modes: Modes, anchor: Modes) -> None:
    where, label = place(case), spec.label
    result.sources[label] = Source(modes.theory, modes.version)
    seen = pair(modes.first(count), anchor, case.mechanism, case.pose)
    for i in range(count):
        partner, like = int(seen.partner[i]), seen.matrix[i]
        shaped = Shaped(float(modes.frequencies[i]), partner + 1, float(like[partner]), like)
        result.modes[where, label, i + 1] = shaped
    f = modes.frequencies
    # Count where there is most room: above the last mode compared, or one further.
    gaps = f[count:] / f[count - 1 : -1]
    if gaps.max(initial=0.0) < APART:
        gaps = np.where(np.arange(1, len(f)) >= 3, f[1:] / f[:-1], 0.0)
    number = len(f) - len(gaps) + int(gaps.argmax())
    cut = float(np.sqrt(f[number - 1] * f[number]))
    result.counts[where, label] = Count(cut, number, f)
    back = pair(anchor.first(count), modes, case.mechanism, case.pose)
    result.found[where, label] = back.assurance


def _orders(result: Measured, study: Study, ladder: Sequence[Spec]) -> None:
    elements = tuple(n for spec in ladder if isinstance(n := spec.elements, int))[-3:]
    labels = tuple(spec.label for spec in ladder)[-3:]
    for case in study.cases:
        if any(study.get(case, spec) is None for spec in ladder[-3:]):
            continue
        for i in range(1, study.count + 1):
            values = followed(result.modes, case.name, labels, i)
            formal = formal_order(ladder[0])
            seen = verify(elements, values, formal)
            if np.isfinite(seen.order):
                order = Order(seen.order, elements, values, labels, formal)
                result.orders[case.name, ladder[0].name, i] = order


def followed(
    modes: Mapping[Key, Shaped], case: str, labels: Sequence[str], mode: int
) -> tuple[float, ...]:
    """Return the frequency of `mode` of the last of `labels` in each of them, by its shape.

    Where a coarse mesh has no such mode among those compared, by its number.
    """
    partner = modes[case, labels[-1], mode].partner
    found = []
    for label in labels:
        numbered = (modes.get((case, label, i)) for i in range(1, MODES + 1))
        alike = [one.frequency for one in numbered if one is not None and one.partner == partner]
        found.append(alike[0] if alike else modes[case, label, mode].frequency)
    return tuple(found)
