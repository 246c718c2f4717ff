"""What must hold without any baseline: one answer however it is asked for, and what is true.

Every bound is derived: from the rounding of the matrices, from the width of certified brackets,
from the limit itself, or from the precision that a model declares.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from analytic import Mechanism, Pose
from analytic.model import Model
from analytic.multipliers import null_space
from harness.bench import Bench, label
from harness.cases import Case
from harness.gate.equivalents import UNITS, answer, relative, turned
from harness.gate.plan import MODES, BatchTask, Checked
from harness.presets import TWINS
from harness.workers import Failure, attempt

Floats = NDArray[np.float64]
BATCH = 1e-9
"""What the batch solver promises."""
Found = tuple[str, Floats, Floats]
"""Case, deviations and bounds, mode by mode."""


@dataclass(frozen=True)
class Property:
    """What must hold: relative `deviation` at most `bound`; worst at `case` and `mode`; and why."""

    name: str
    model: str
    case: str
    mode: int | None
    deviation: float
    bound: float
    remark: str

    @property
    def holds(self) -> bool:
        """Whether it does."""
        return self.deviation <= self.bound


def properties(checked: Checked, bench: Bench) -> list[Property]:
    """Return every property that the models solved in `checked` can show."""
    from harness.gate.truths import truths

    return [
        *_equivalents(checked, bench),
        *_symmetry(checked),
        *_twins(checked, bench),
        *_batches(checked),
        *truths(checked, bench),
    ]


def worst(name: str, model: str, found: Sequence[Found], remark: str) -> Iterator[Property]:
    """Yield the property at its worst: the largest deviation over its bound."""
    if not found:
        return
    with np.errstate(invalid="ignore", divide="ignore"):
        ratios = [np.nan_to_num(d / b, nan=0.0, posinf=np.inf) for _, d, b in found]
    k = int(np.argmax([ratio.max() for ratio in ratios]))
    case, deviation, bound = found[k]
    i = int(ratios[k].argmax())
    yield Property(name, model, case, i + 1, float(deviation[i]), float(bound[i]), remark)


def precision(model: Model, mechanism: Mechanism, pose: Pose, count: int) -> Floats:
    """Return how far rounding may move each frequency of a model, relative, (count,).

    What the model declares; or, where it shows its matrices: every entry of K and M, in the
    coordinates that are solved for, is known to some roundings, so that |df / f| <= n eps
    (|x|^T |K| |x| + omega^2 |x|^T |M| |x|) / (2 omega^2 x^T M x), with n the coordinates of a limb,
    as many as a sum has terms.
    """
    info = model.info()
    build = getattr(model, "build", None)
    built = model if build is None or info.isolated else build()
    matrices = getattr(built, "matrices", None)
    if matrices is None:
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
    terms = 6 * (model.elements + 1)
    with np.errstate(divide="ignore"):
        bound = np.abs(terms * np.finfo(float).eps * entries / (2 * values * mass))
    return np.asarray(bound)


def _equivalents(checked: Checked, bench: Bench) -> Iterator[Property]:
    """The same problem in other words, by every model's coarsest mesh and every exact one."""
    plan, study = checked.plan, checked.cases
    models = [ladder[0] for ladder in plan.ladders]
    models += [one for one in plan.singles if not isinstance(one.elements, tuple)]
    for model in dict.fromkeys(models):
        cases = study.complete(model)
        for equivalent in UNITS:
            found = []
            # A slow model is asked where nothing is symmetrical.
            for case in cases[-1:] if model.info().slow else cases:
                f = study.answers[case, model].frequencies[: study.count]
                changed = equivalent.change(case.mechanism, case.pose)
                again = answer(bench, model, *changed, study.count)
                # Rounding depends on the units: the bound is that of the changed problem.
                bound = np.maximum(
                    precision(model, case.mechanism, case.pose, study.count),
                    precision(model, *changed, study.count),
                )
                if again is None:
                    deviation = np.full(study.count, np.inf)
                else:
                    deviation = relative(again / equivalent.factor, f)
                found.append((case.name, deviation, bound))
            yield from worst(equivalent.name, label(model), found, "rounding")


def _symmetry(checked: Checked) -> Iterator[Property]:
    """Equal limbs around a circle: turning the azimuth from one to the next changes nothing."""
    study = checked.workspace
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
        found = []
        for first, *others in groups.values():
            f = study.answers[first, model].frequencies[: study.count]
            bound = precision(model, mechanism, first.pose, study.count)
            for case in others:
                again = study.answers[case, model].frequencies[: study.count]
                found.append((case.name, relative(again, f), bound))
        yield from worst(f"{step:g} deg symmetry", label(model), found, "rounding")


def _repeats(mechanism: Mechanism, angle: float) -> bool:
    """Return whether the mechanism turned by `angle` [rad] is itself, limbs renumbered."""
    turned_one, _ = turned(angle)(mechanism, Pose(1.0))
    size = max(np.abs(mechanism.bases).max(), np.abs(mechanism.platform_points).max())

    def close(a: object, b: object) -> bool:
        return np.allclose(np.asarray(a), np.asarray(b), rtol=0, atol=1e-9 * size)

    inertia = np.array(mechanism.platform.inertia)
    again = np.array(turned_one.platform.inertia)
    return np.allclose(again, inertia, rtol=0, atol=1e-9 * np.abs(inertia).max()) and all(
        any(
            close(limb.base, other.base)
            and np.allclose(limb.axis, other.axis, atol=1e-9)
            and close(limb.platform_point, other.platform_point)
            and limb.rod == other.rod
            for other in mechanism.limbs
        )
        for limb in turned_one.limbs
    )


def _twins(checked: Checked, bench: Bench) -> Iterator[Property]:
    """The same elements put together or solved in other ways."""
    study, plan = checked.cases, checked.plan
    for one, other in TWINS:
        if one.name in plan.skipped or other.name in plan.skipped:
            continue
        found = []
        for case in study.complete(one):
            own = case.mechanism, case.pose
            f = study.answers[case, one].frequencies[: study.count]
            again = answer(bench, other, *own, study.count)
            bound = precision(one, *own, study.count) + precision(other, *own, study.count)
            deviation = np.full(study.count, np.inf) if again is None else relative(again, f)
            found.append((case.name, deviation, bound))
        yield from worst(f"{label(other)} = {label(one)}", label(other), found, "rounding of both")


def _batches(checked: Checked) -> Iterator[Property]:
    """Many poses a call, against the same model pose by pose."""
    for model, batch in checked.batches.items():
        study = checked.workspace
        found = [
            (case.name, *_off(study.answers[case, model].frequencies, f, model, case))
            for case, f in zip(study.cases, batch.table, strict=True)
            if (case, model) in study.answers
        ]
        yield from worst("many poses a call, map", label(model), found, "the batch solver's 1e-9")
    study = checked.cases
    for model in study.models:
        if model.info().isolated or model.elements not in (3, None):
            continue
        found = []
        for case in study.complete(model):
            some = attempt(BatchTask(model, (case,)))
            table = np.full((1, MODES), np.nan) if isinstance(some, Failure) else some.table  # type: ignore[attr-defined]
            modes = study.answers[case, model]
            found.append((case.name, *_off(modes.frequencies, table[0], model, case)))
        yield from worst("many poses a call, cases", label(model), found, "the batch solver's 1e-9")


def _off(f: Floats, batch: Floats, model: Model, case: Case) -> tuple[Floats, Floats]:
    bound = BATCH + precision(model, case.mechanism, case.pose, MODES)
    return np.nan_to_num(relative(batch, f[:MODES]), nan=np.inf), bound
