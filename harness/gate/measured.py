"""What a check compares: frequencies, what each mode looks like, mode counts, orders, versions."""

from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from analytic import InputError, Modes
from analytic.pairing import Pairing, pair
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


@dataclass(frozen=True)
class Measured:
    """Everything that is compared, by where it belongs.

    Attributes: `modes`, `uncertainties` [Hz] of models that state them, `counts`, `orders`;
    `sources` by label; `mechanisms`, their hashes, by case. Only where just measured: `answers`
    by place: the modes, their pairing with the anchor's, and the anchor's with them.
    """

    modes: dict[Key, Shaped] = field(default_factory=dict)
    uncertainties: dict[Key, float] = field(default_factory=dict)
    counts: dict[Place, Count] = field(default_factory=dict)
    orders: dict[Key, Order] = field(default_factory=dict)
    sources: dict[str, Source] = field(default_factory=dict)
    mechanisms: dict[str, str] = field(default_factory=dict)
    answers: dict[Place, tuple[Modes, Pairing, Pairing]] = field(default_factory=dict)

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

        def kept(of: Mapping[Any, Any]) -> dict[Any, Any]:
            return {key: one for key, one in of.items() if not {*labels} & {*_models(key, one)}}

        return Measured(**{name: kept(getattr(self, name)) for name in STORED})

    def updated(self, newer: "Measured") -> "Measured":
        """Return these figures with those of `newer` in their place.

        A model measured again leaves nothing old behind.
        """
        kept = self.without(newer.sources)
        return Measured(**{name: getattr(kept, name) | getattr(newer, name) for name in STORED})

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


STORED = [one.name for one in fields(Measured)][:6]
"""What of `Measured` is kept; the rest is for comparing it."""


def _models(key: Any, one: Any) -> Sequence[str]:
    """Return the labels of the models that a figure is of."""
    if isinstance(one, Order):
        return one.labels(key[1])
    return [key if isinstance(key, str) else key[1]]


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
                    result.orders[case.name, ladder[0].name, i] = Order(p, formal, elements)
    return result


def _add(result: Measured, case: Case, model: str, modes: Modes, anchor: Modes) -> None:
    """Take in the modes of one model at one case, and what they look like."""
    where = case.name, model
    result.sources[model] = Source(modes.theory, modes.version)
    seen = pair(modes.first(MODES), anchor, case.mechanism, case.pose)
    back = pair(anchor.first(MODES), modes, case.mechanism, case.pose)
    result.answers[where] = modes, seen, back
    for i, (f, partner, like) in enumerate(
        zip(
            modes.frequencies.tolist(), seen.partner.tolist(), seen.assurance.tolist(), strict=False
        )
    ):
        result.modes[*where, i + 1] = Shaped(f, partner + 1, like)
        if modes.uncertainty is not None:
            result.uncertainties[*where, i + 1] = float(modes.uncertainty[i])
    result.counts[where] = counted(modes.frequencies, MODES)


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
    return Count(float(np.sqrt(f[number - 1] * f[number])), number)
