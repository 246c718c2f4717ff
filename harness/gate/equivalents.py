"""The same mechanism said differently: whatever a model answers must be the same, but for rounding.

The spread of the answers is the model's numerical noise, measured rather than assumed; what is
allowed is derived from the rounding of its matrices, or the precision that it declares.
"""

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
import scipy
from scipy.spatial.distance import cdist

from analytic import Body, Mechanism, Modes, Pose
from analytic.mechanism import Item
from analytic.model import Model
from analytic.multipliers import null_space
from harness.answer import Batch
from harness.bench import SPARE, Bench, Study, label
from harness.case import Case
from harness.gate.figures import FAILED, HELD, Finding
from harness.gate.plan import MODES, Checked, batch
from harness.poses import turn, turned
from harness.presets import TWINS
from harness.signatures import Array
from harness.workers import Failure
from reference_models.units import Units

Change = Callable[[Case], Case]
Seen = tuple[float, Finding]
"""A property at one case, and its deviation over its bound."""
BATCH = 1e-9
"""What the batch solver promises."""


@dataclass(frozen=True)
class Equivalent:
    """A change that leaves the problem as it was, its frequencies multiplied by `factor`."""

    name: str
    change: Change
    factor: float = 1.0


def posed(case: Case, mechanism: Mechanism, pose: Pose) -> Case:
    """Return the case with another mechanism and pose; of any units: nothing is warned of."""
    with warnings.catch_warnings(action="ignore"):
        return replace(case, mechanism=mechanism, pose=pose)


def renumbered(case: Case) -> Case:
    """Return the case with its mechanism's first limb last."""
    first, *others = case.mechanism.limbs
    return posed(case, replace(case.mechanism, limbs=(*others, first)), case.pose)


def turned_axes(angle: float) -> Change:
    """Return the change to axes turned by -`angle` [rad] about z."""
    R = turn(2, angle)

    def item(i: Item) -> Item:  # a body in global axes turns with them too
        return replace(i, frame="base") if isinstance(i, Body) and i.frame == "global" else i

    def change(case: Case) -> Case:
        limbs = tuple(
            replace(limb, chain=tuple(map(item, limb.chain))).turned(angle)
            for limb in case.mechanism.limbs
        )
        body = case.mechanism.platform
        inertia = R @ np.array(body.inertia) @ R.T
        x, y, z = (tuple(row) for row in ((inertia + inertia.T) / 2).tolist())
        platform = replace(body, inertia=(x, y, z), centre=tuple((R @ body.centre).tolist()))
        return posed(case, Mechanism(limbs, platform), turned(case.pose, angle))

    return change


def in_units(length: float = 1.0, mass: float = 1.0, time: float = 1.0) -> Change:
    """Return the change to units of `length` [m], `mass` [kg] and `time` [s]."""
    units = Units(length, mass, time)
    return lambda case: posed(case, units.mechanism(case.mechanism), units.pose(case.pose))


EQUIVALENTS = (
    Equivalent("limbs renumbered", renumbered),
    Equivalent("axes turned by 57.3 deg", turned_axes(1.0)),
    Equivalent("axes turned by -131.8 deg", turned_axes(-2.3)),
    # Not a power of two: every digit changes, also those that a program prints.
    Equivalent("time unit 1.7 s", in_units(time=1.7), 1.7),
)
UNITS = (
    *EQUIVALENTS,
    Equivalent("mass unit 1/0.3 kg", in_units(mass=1 / 0.3)),
    Equivalent("lengths in mm", in_units(length=1e-3)),
)


def noise(
    bench: Bench,
    model: Model,
    case: Case,
    f: Array,
    equivalents: Sequence[Equivalent] = EQUIVALENTS,
) -> Array:
    """Return the largest relative deviation among `equivalents` of a model's own `f` (MODES,).

    Infinite where the model fails at one of them.
    """
    again = [answer(bench, model, one.change(case)) / one.factor for one in equivalents]
    return np.asarray(relative(again, f).max(axis=0))


def relative(value: Any, against: Any) -> Array:
    """Return |value / against - 1|; of two zeros, the frequencies of one free motion, 0."""
    a, b = np.broadcast_arrays(np.asarray(value, dtype=float), np.asarray(against, dtype=float))
    off = np.where(a == b, 0.0, np.inf)
    np.divide(np.abs(a - b), np.abs(b), out=off, where=b != 0)
    return off


def answer(bench: Bench, model: Model, case: Case) -> Array:
    """Return the lowest frequencies (MODES,) [Hz]; infinite where the model fails."""
    modes = bench.solve(model, case.mechanism, case.pose, MODES + SPARE)
    return modes.frequencies[:MODES] if isinstance(modes, Modes) else np.full(MODES, np.inf)


def solved(study: Study, case: Case, model: Model) -> Array:
    """Return the frequencies (MODES,) [Hz] that a study holds."""
    return study.answers[case, model].frequencies[:MODES]


def precision(model: Model, case: Case) -> Array:
    """Return how far rounding may move each frequency of a model, relative, (MODES,).

    What the model declares; or, where it shows its matrices: every entry of K and M, in the
    coordinates that are solved for, is known to some roundings, so that |df / f| <= n eps
    (|x|^T |K| |x| + omega^2 |x|^T |M| |x|) / (2 omega^2) for x^T M x = 1, with n the coordinates of
    a limb, as many as a sum has terms. The eigen-solution of (M, K) adds eps of the largest
    eigenvalue, which belongs to the lowest elastic mode: eps omega^2 / omega_1^2.
    """
    build = getattr(model, "build", None)
    built = model if build is None or model.info().isolated else build()
    matrices = getattr(built, "matrices", None)
    if matrices is None or not case.mechanism.simple:
        return np.full(MODES, getattr(built, "info", model.info)().precision)
    assert isinstance(model.elements, int), "matrices are of elements"
    K, M, *constraints = matrices(case.mechanism, case.pose)
    if constraints:
        N = null_space(constraints[0])
        K, M = N.T @ K @ N, N.T @ M @ N
    K, M = (np.asarray(A.toarray() if hasattr(A, "toarray") else A) for A in (K, M))
    values, x = scipy.linalg.eigh(K, M, subset_by_index=(0, MODES - 1))
    y = np.abs(x)
    entries = (y * (np.abs(K) @ y)).sum(axis=0) + values * (y * (np.abs(M) @ y)).sum(axis=0)
    eps, terms = np.finfo(float).eps, 6 * (model.elements + 1)
    lowest = values[values > eps**0.5 * values[-1]][0]
    with np.errstate(divide="ignore"):
        known = np.abs(terms * eps * entries / (2 * values))
    return np.asarray(known + eps * np.abs(values) / lowest)


def rounding(case: Case, *models: Model) -> Array:
    """Return how far rounding may move the frequencies of `models` apart at a case, (MODES,)."""
    return sum((precision(model, case) for model in models), start=np.zeros(MODES))


def seen(name: str, model: Model | str, remark: str, case: Case, off: Array, bound: Array) -> Seen:
    """Return what one case shows of a property of a model, at the mode where it shows most.

    `off`: relative deviations, `bound`: those allowed, mode by mode; `remark`: where they are from.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        ratios = np.nan_to_num(off / bound, nan=0.0, posinf=np.inf)
    i = int(ratios.argmax())
    named = model if isinstance(model, str) else label(model)
    verdict = HELD if off[i] <= bound[i] else FAILED
    return float(ratios[i]), Finding("property", named, case.name, i + 1, name, None, float(off[i]),
                                     float(bound[i]), verdict, remark)  # fmt: skip


def _equivalents(checked: Checked) -> Iterator[Seen]:
    """The same problem in other words, by every model's coarsest mesh and every exact one."""
    plan, study = checked.plan, checked.cases
    models = [ladder[0] for ladder in plan.ladders]
    models += [one for one in plan.singles if not isinstance(one.elements, tuple)]
    for model in dict.fromkeys(models):
        cases = study.complete(model)
        # A slow model is asked where nothing is symmetrical.
        for one, case in product(UNITS, cases[-1:] if model.info().slow else cases):
            changed = one.change(case)
            again = answer(checked.bench, model, changed) / one.factor
            off = relative(again, solved(study, case, model))
            # Rounding depends on the units: the bound is that of the changed problem.
            bound = np.maximum(precision(model, case), precision(model, changed))
            yield seen(one.name, model, "rounding", case, off, bound)


def _symmetry(checked: Checked) -> Iterator[Seen]:
    """Equal limbs around a circle: turning the azimuth from one to the next changes nothing."""
    study = checked.workspace
    if not study.cases:
        return
    step = 360 / len(study.cases[0].mechanism.limbs)
    if not _repeats(study.cases[0], np.radians(step)):
        return
    for model in study.models:
        groups: dict[tuple[float, float, float], Case] = {}
        for case in study.complete(model):
            turn = round(float(np.degrees(case.pose.azimuth)) % step, 6) % step
            first = groups.setdefault((case.pose.z, case.pose.tilt, turn), case)
            if first is not case:
                off = relative(solved(study, case, model), solved(study, first, model))
                bound = precision(model, first)
                yield seen(f"{step:g} deg symmetry", model, "rounding", case, off, bound)


def _repeats(case: Case, angle: float) -> bool:
    """Return whether the mechanism turned by `angle` [rad] is itself, limbs renumbered.

    Of limbs other than R-P-S it is not asked.
    """
    mechanism = case.mechanism
    if not mechanism.simple:
        return False
    turned = turned_axes(angle)(case).mechanism
    rods = [limb.rod for limb in mechanism.limbs]
    size = max(np.abs(mechanism.bases).max(), np.abs(mechanism.platform_points).max())

    def places(one: Mechanism) -> Array:
        kinds = np.array([[rods.index(limb.rod)] for limb in one.limbs])
        return np.hstack([one.bases, one.platform_points, size * one.axes, size * kinds])

    apart = cdist(places(turned), places(mechanism), "chebyshev").min(axis=1)
    inertia = np.array(mechanism.platform.inertia)
    off = np.abs(turned.platform.inertia - inertia).max()
    return bool(apart.max() <= 1e-9 * size and off <= 1e-9 * np.abs(inertia).max())


def _twins(checked: Checked) -> Iterator[Seen]:
    """The same elements put together or solved in other ways."""
    study = checked.cases
    for one, other in TWINS:
        name = f"{label(other)} = {label(one)}"
        if not {one.name, other.name} & checked.plan.skipped.keys():
            for case in study.complete(one):
                off = relative(answer(checked.bench, other, case), solved(study, case, one))
                bound = rounding(case, one, other)
                yield seen(name, other, "rounding of both", case, off, bound)


def _batches(checked: Checked) -> Iterator[Seen]:
    """Many poses a call, against the same model pose by pose."""
    space, study = checked.workspace, checked.cases
    asked: list[tuple[str, Study, Model, tuple[Case, ...], Batch | Failure]] = [
        ("map", space, model, space.cases, many)
        for model, many in checked.batches.items()
        if isinstance(many, Batch)
    ]
    asked += [
        ("cases", study, model, (case,), batch(model, (case,)))
        for model in study.models
        if model.elements in (3, None) and not model.info().isolated
        for case in study.complete(model)
    ]
    for where, of, model, cases, many in asked:
        name, failed = f"many poses a call, {where}", np.full((len(cases), MODES), np.inf)
        for case, f in zip(cases, many.table if isinstance(many, Batch) else failed, strict=True):
            if (case, model) in of.answers:
                off = np.nan_to_num(relative(f, solved(of, case, model)), nan=np.inf)
                bound = BATCH + rounding(case, model)
                yield seen(name, model, "the batch solver's 1e-9", case, off, bound)


SAME_ANSWERS = (_equivalents, _symmetry, _twins, _batches)
"""What of this can be asked of the models solved in a check."""
