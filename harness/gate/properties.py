"""What must hold without any baseline: one answer however it is asked for, and what is true.

Every bound is derived: from the rounding of the matrices, from the width of certified brackets,
from the limit itself, or from the precision that a model declares.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, product

import numpy as np
import scipy
from numpy.typing import NDArray

from analytic import Mechanism, Pose
from analytic.model import Model
from analytic.multipliers import null_space
from harness.answer import Batch
from harness.bench import Bench, Study, label
from harness.case import Case
from harness.gate.equivalents import UNITS, answer, relative, turned_axes
from harness.gate.finding import Finding, judged
from harness.gate.plan import MODES, Checked, batch
from harness.presets import TWINS

Floats = NDArray[np.float64]
BATCH = 1e-9
"""What the batch solver promises."""


@dataclass(frozen=True)
class Seen:
    """What one case shows of a property of a model: relative `deviation` and `bound`, mode by mode.

    `remark`: what the bound comes from.
    """

    name: str
    model: str
    remark: str
    case: str
    deviation: Floats
    bound: Floats

    def worst(self) -> tuple[float, Finding]:
        """Return the largest deviation over its bound, and the property at that mode."""
        with np.errstate(invalid="ignore", divide="ignore"):
            ratios = np.nan_to_num(self.deviation / self.bound, nan=0.0, posinf=np.inf)
        i = int(ratios.argmax())
        deviation, bound = float(self.deviation[i]), float(self.bound[i])
        verdict = judged(deviation <= bound)
        return float(ratios[i]), Finding("property", self.model, self.case, i + 1, self.name, None,
                                         deviation, bound, verdict, self.remark)  # fmt: skip


def properties(checked: Checked, bench: Bench) -> list[Finding]:
    """Return every property that the models solved in `checked` can show, each at its worst."""
    from harness.gate.truths import truths

    found: dict[tuple[str, str], list[tuple[float, Finding]]] = {}
    for seen in chain(
        _equivalents(checked, bench),
        _symmetry(checked.workspace),
        _twins(checked, bench),
        _batches(checked),
        truths(checked, bench),
    ):
        found.setdefault((seen.name, seen.model), []).append(seen.worst())
    return [max(some, key=lambda one: one[0])[1] for some in found.values()]


def solved(study: Study, case: Case, model: Model) -> Floats:
    """Return the frequencies (MODES,) [Hz] that a study holds."""
    return study.answers[case, model].frequencies[:MODES]


def precision(model: Model, mechanism: Mechanism, pose: Pose, count: int = MODES) -> Floats:
    """Return how far rounding may move each frequency of a model, relative, (count,).

    What the model declares; or, where it shows its matrices: every entry of K and M, in the
    coordinates that are solved for, is known to some roundings, so that |df / f| <= n eps
    (|x|^T |K| |x| + omega^2 |x|^T |M| |x|) / (2 omega^2 x^T M x), with n the coordinates of a limb,
    as many as a sum has terms. The eigen-solution of (M, K) adds eps of the largest eigenvalue,
    which belongs to the lowest elastic mode: eps omega^2 / omega_1^2.
    """
    build = getattr(model, "build", None)
    built = model if build is None or model.info().isolated else build()
    matrices = getattr(built, "matrices", None)
    if matrices is None or not mechanism.simple:
        return np.full(count, getattr(built, "info", model.info)().precision)
    assert isinstance(model.elements, int), "matrices are of elements"
    K, M, *constraints = matrices(mechanism, pose)
    if constraints:
        N = null_space(constraints[0])
        K, M = N.T @ K @ N, N.T @ M @ N
    K, M = (np.asarray(A.toarray() if hasattr(A, "toarray") else A) for A in (K, M))
    values, x = scipy.linalg.eigh(K, M, subset_by_index=(0, count - 1))
    y = np.abs(x)
    entries = (y * (np.abs(K) @ y)).sum(axis=0) + values * (y * (np.abs(M) @ y)).sum(axis=0)
    mass = (x * (M @ x)).sum(axis=0)
    eps, terms = np.finfo(float).eps, 6 * (model.elements + 1)
    lowest = values[values > eps**0.5 * values[-1]][0]
    with np.errstate(divide="ignore"):
        known = np.abs(terms * eps * entries / (2 * values * mass))
    return np.asarray(known + eps * np.abs(values) / lowest)


def rounding(case: Case, *models: Model) -> Floats:
    """Return how far rounding may move the frequencies of `models` apart at a case, (MODES,)."""
    return sum(
        (precision(model, case.mechanism, case.pose) for model in models), start=np.zeros(MODES)
    )


def _equivalents(checked: Checked, bench: Bench) -> Iterator[Seen]:
    """The same problem in other words, by every model's coarsest mesh and every exact one."""
    plan, study = checked.plan, checked.cases
    models = [ladder[0] for ladder in plan.ladders]
    models += [one for one in plan.singles if not isinstance(one.elements, tuple)]
    for model in dict.fromkeys(models):
        cases = study.complete(model)
        # A slow model is asked where nothing is symmetrical.
        for one, case in product(UNITS, cases[-1:] if model.info().slow else cases):
            changed = one.change(case.mechanism, case.pose)
            again = answer(bench, model, *changed, MODES) / one.factor
            off = relative(again, solved(study, case, model))
            # Rounding depends on the units: the bound is that of the changed problem.
            bound = np.maximum(rounding(case, model), precision(model, *changed))
            yield Seen(one.name, label(model), "rounding", case.name, off, bound)


def _symmetry(study: Study) -> Iterator[Seen]:
    """Equal limbs around a circle: turning the azimuth from one to the next changes nothing."""
    if not study.cases:
        return
    mechanism = study.cases[0].mechanism
    step = 360 / len(mechanism.limbs)
    if not _repeats(mechanism, np.radians(step)):
        return
    for model in study.models:
        groups: dict[tuple[float, float, float], list[Case]] = {}
        for case in study.complete(model):
            turn = round(float(np.degrees(case.pose.azimuth)) % step, 6) % step
            groups.setdefault((case.pose.z, case.pose.tilt, turn), []).append(case)
        for first, *others in groups.values():
            f, bound = solved(study, first, model), rounding(first, model)
            for case in others:
                off = relative(solved(study, case, model), f)
                yield Seen(
                    f"{step:g} deg symmetry", label(model), "rounding", case.name, off, bound
                )


def _repeats(mechanism: Mechanism, angle: float) -> bool:
    """Return whether the mechanism turned by `angle` [rad] is itself, limbs renumbered.

    Of limbs other than R-P-S it is not asked.
    """
    if not mechanism.simple:
        return False
    turned, _ = turned_axes(angle)(mechanism, Pose(1.0))
    size = max(np.abs(mechanism.bases).max(), np.abs(mechanism.platform_points).max())
    inertia, again = np.array(mechanism.platform.inertia), np.array(turned.platform.inertia)
    places = [
        np.array([(*limb.base, *limb.platform_point, *(size * np.array(limb.axis)))
                  for limb in one.limbs])
        for one in (mechanism, turned)
    ]  # fmt: skip
    apart = np.abs(places[0][None] - places[1][:, None]).max(axis=2)
    rods = [[a.rod == b.rod for b in mechanism.limbs] for a in turned.limbs]
    same = ((apart <= 1e-9 * size) & rods).any(axis=1).all()
    return bool(same and np.abs(again - inertia).max() <= 1e-9 * np.abs(inertia).max())


def _twins(checked: Checked, bench: Bench) -> Iterator[Seen]:
    """The same elements put together or solved in other ways."""
    study = checked.cases
    for one, other in TWINS:
        if {one.name, other.name} & checked.plan.skipped.keys():
            continue
        name = f"{label(other)} = {label(one)}"
        for case in study.complete(one):
            again = answer(bench, other, case.mechanism, case.pose, MODES)
            off, bound = relative(again, solved(study, case, one)), rounding(case, one, other)
            yield Seen(name, label(other), "rounding of both", case.name, off, bound)


def _batches(checked: Checked) -> Iterator[Seen]:
    """Many poses a call, against the same model pose by pose."""
    space, study = checked.workspace, checked.cases
    asked = [
        ("map", space, model, case, f)
        for model, many in checked.batches.items()
        if isinstance(many, Batch)
        for case, f in zip(space.cases, many.table, strict=True)
        if (case, model) in space.answers
    ]
    for model in study.models:
        if model.elements in (3, None) and not model.info().isolated:
            for case in study.complete(model):
                one = batch(model, (case,))
                f = one.table[0] if isinstance(one, Batch) else np.full(MODES, np.inf)
                asked.append(("cases", study, model, case, f))
    for where, of, model, case, f in asked:
        off = np.nan_to_num(relative(f, solved(of, case, model)), nan=np.inf)
        bound, name = BATCH + rounding(case, model), f"many poses a call, {where}"
        yield Seen(name, label(model), "the batch solver's 1e-9", case.name, off, bound)
