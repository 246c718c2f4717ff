"""What a check compares: frequencies, what each mode looks like, mode counts, orders, versions."""

from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields
from itertools import product

import numpy as np
from numpy.typing import NDArray

from analytic import InputError, Modes
from analytic.pairing import pair
from harness.bench import SPARE, Bench, label
from harness.case import Case
from harness.gate.plan import MODES, Checked, group
from harness.rows import mechanism_hash
from harness.studies.refinement import MESHES, verify
from harness.workers import Failure
from reference_models import Named, parse

Key = tuple[str, str, int]
"""Case (or pose of the map), model's label, mode from 1. Orders: model's name."""
Place = tuple[str, str]
ANCHOR = Named("timoshenko", 4)
"""The model whose modes say what a mode looks like: solved anew in every check."""
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
    """An observed order `p` on meshes of `elements` a limb; the `formal` one."""

    p: float
    elements: tuple[int, ...]
    formal: float

    def labels(self, name: str) -> list[str]:
        """Return what the meshes of the model called `name` are called."""
        return [label(Named(name, n)) for n in self.elements]


@dataclass(frozen=True)
class Source:
    """What a model assumes, and the program behind it."""

    theory: str
    version: str


@dataclass(frozen=True)
class Measured:
    """Everything that is compared, by where it belongs.

    Attributes: `modes`, `uncertainties` [Hz] of models that state them, `counts`, `orders`;
    `sources` by label; `mechanisms`, their hashes, by case. Only where just measured: `found`, by
    place, the assurance with which each of the anchor's modes is among the model's.
    """

    modes: dict[Key, Shaped] = field(default_factory=dict)
    uncertainties: dict[Key, float] = field(default_factory=dict)
    counts: dict[Place, Count] = field(default_factory=dict)
    orders: dict[Key, Order] = field(default_factory=dict)
    sources: dict[str, Source] = field(default_factory=dict)
    mechanisms: dict[str, str] = field(default_factory=dict)
    found: dict[Place, NDArray[np.float64]] = field(default_factory=dict)

    @property
    def places(self) -> dict[Place, None]:
        """Where modes were measured, in order."""
        return dict.fromkeys((case, model) for case, model, _ in self.modes)

    @property
    def simulators(self) -> set[str]:
        """Names of the simulators that there are figures of; not of models that are gone."""
        found = set()
        for model in self.sources:
            with suppress(InputError):
                named = parse(model, "baseline")
                found |= {named.name} if named.info().isolated else set()
        return found

    def without(self, labels: Collection[str]) -> "Measured":
        """Return these figures without those of the models called `labels`."""
        return Measured(
            {k: v for k, v in self.modes.items() if k[1] not in labels},
            {k: v for k, v in self.uncertainties.items() if k[1] not in labels},
            {k: v for k, v in self.counts.items() if k[1] not in labels},
            {k: v for k, v in self.orders.items() if not {*labels} & {*v.labels(k[1])}},
            {k: v for k, v in self.sources.items() if k not in labels},
            self.mechanisms,
        )

    def updated(self, newer: "Measured") -> "Measured":
        """Return these figures with those of `newer` in their place.

        A model measured again leaves nothing old behind.
        """
        kept = self.without(newer.sources)
        return Measured(*(getattr(kept, x.name) | getattr(newer, x.name) for x in STORED))

    def followed(self, case: str, labels: Sequence[str], mode: int) -> NDArray[np.float64]:
        """Return the frequency [Hz] of `mode` of the last of `labels` in each of them.

        It is followed by its shape; where a coarse mesh has no such mode among those compared, by
        its number.
        """
        partner = self.modes[case, labels[-1], mode].partner
        found = []
        for one in labels:
            numbered = (self.modes.get((case, one, i)) for i in range(1, MODES + 1))
            alike = [
                shaped.frequency for shaped in numbered if shaped and shaped.partner == partner
            ]
            found.append(alike[0] if alike else self.modes[case, one, mode].frequency)
        return np.array(found)


STORED = fields(Measured)[:6]
"""What of `Measured` is kept; the rest is for comparing it."""


def measure(checked: Checked, bench: Bench) -> Measured:
    """Return what a check compares, out of all that was solved."""
    result = Measured()
    for study in checked.studies:
        for case, model in product(study.cases, study.models):
            modes = study.get(case, model)
            if modes is None:
                continue
            result.mechanisms[group(case.name)] = mechanism_hash(case.mechanism)
            anchor = bench.solve(ANCHOR, case.mechanism, case.pose, MODES + SPARE)
            if not isinstance(anchor, Failure):
                _add(result, case, label(model), modes, anchor)
    for ladder in checked.plan.ladders:
        last = ladder[-MESHES:]
        elements = tuple(n for model in last if isinstance(n := model.elements, int))
        formal = ladder[0].info().order
        for case in checked.cases.complete(*last) if len(last) == MESHES else ():
            for i in range(1, MODES + 1):
                values = result.followed(case.name, [label(model) for model in last], i)
                p = verify(elements, values.tolist(), formal).order
                if np.isfinite(p):
                    result.orders[case.name, ladder[0].name, i] = Order(p, elements, formal)
    return result


def _add(result: Measured, case: Case, model: str, modes: Modes, anchor: Modes) -> None:
    """Take in the modes of one model at one case, and what they look like."""
    where = case.name, model
    result.sources[model] = Source(modes.theory, modes.version)
    seen = pair(modes.first(MODES), anchor, case.mechanism, case.pose)
    for i, (partner, like) in enumerate(zip(seen.partner.tolist(), seen.matrix, strict=True)):
        shaped = Shaped(float(modes.frequencies[i]), partner + 1, float(like[partner]), like)
        result.modes[*where, i + 1] = shaped
        if modes.uncertainty is not None:
            result.uncertainties[*where, i + 1] = float(modes.uncertainty[i])
    result.counts[where] = counted(modes.frequencies, MODES)
    back = pair(anchor.first(MODES), modes, case.mechanism, case.pose)
    result.found[where] = back.assurance


def counted(f: NDArray[np.float64], count: int) -> Count:
    """Return a cut where there is most room: above the last of `count` modes, or one further.

    Where neither has room (`APART`), the widest gap from the fourth mode on.
    """
    gaps = np.divide(f[1:], f[:-1], out=np.ones(len(f) - 1), where=f[:-1] > 0)
    gaps[: count - 1] = np.where(
        gaps[count - 1 :].max(initial=0.0) < APART, gaps[: count - 1], 0.0
    )  # fmt: skip
    gaps[:2] = 0.0
    number = 1 + int(gaps.argmax())
    return Count(float(np.sqrt(f[number - 1] * f[number])), number, f)
