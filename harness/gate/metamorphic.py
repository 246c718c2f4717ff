"""What must hold without any baseline: symmetries, units, limits, order of theories, agreement.

Every bound is derived: from the rounding of the matrices, from the width of certified brackets, or
from the limit itself.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from analytic import (
    Continuum,
    Material,
    Mechanism,
    Multipliers,
    Pose,
    Substructure,
    condensed_frequencies,
    limbs_at,
)
from analytic.multipliers import null_space
from analytic.substructure import platform_mass, rigid_arm
from analytic.theory import BEAMS, Theory
from analytic.certified import WIDTH
from harness.cases import Case
from harness.gate.equivalents import (
    EQUIVALENTS,
    Equivalent,
    in_length_unit,
    in_mass_unit,
    with_material,
)
from harness.gate.measured import place
from harness.gate.study import Checked, Formulation
from harness.models import Spec, formal_order
from harness.refinement import verify
from harness.run import GATE, SPARE

Floats = NDArray[np.float64]
UNITS = (
    *EQUIVALENTS,
    Equivalent("mass unit 1/0.3 kg", in_mass_unit(0.3)),
    Equivalent("lengths in mm", in_length_unit(1000.0)),
)
BRACKETS = 2 * WIDTH
"""Two certified brackets: how far exact answers to one question may lie apart."""
BATCH = 1e-9
"""What `condensed_frequencies` promises."""
MULTIBODY = 1e-9
"""A simulator's own matrices in double precision, of condition 1e6."""
DIFFERENCES = {"mujoco-cable": 1e-7}
"""Stiffness by central differences of step 1e-7 m about coordinates of 0.5 m: 5e-10 of EA / l, the
largest entry, which is some hundred times the stiffness against bending."""
LIGHT, STIFF = 1e-9, 1e9
"""Density of limbs without mass, part of their own; shear coefficient of limbs without shear."""


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


def properties(checked: Checked) -> list[Property]:
    """Return every property that the models solved in `checked` can show."""
    return [
        *_equivalents(checked),
        *_symmetry(checked),
        *_formulations(checked),
        *_batch(checked),
        *_limits(checked),
        *_theories(checked),
        *_massless(checked),
        *_counts(checked),
    ]


def rounding(spec: Spec, mechanism: Mechanism, pose: Pose, count: int) -> Floats:
    """Return how far rounding may move each frequency of an analytic model, relative, (count,).

    Exact: `BRACKETS`. Of elements: every entry of K and M, in the coordinates that are solved for,
    is known to some roundings, so that |df / f| <= n eps (|x|^T |K| |x| + omega^2 |x|^T |M| |x|) /
    (2 omega^2 x^T M x), with n the coordinates of a limb, as many as a sum has terms.
    """
    if not isinstance(spec.elements, int):
        return np.full(count, BRACKETS)
    if isinstance(spec, Formulation):
        K_free, M_free, C = Multipliers(spec.elements).matrices(mechanism, pose)
        N = null_space(C)
        K, M = (N.T @ K_free @ N).toarray(), (N.T @ M_free @ N).toarray()
    else:
        pair = Substructure(spec.elements, spec.name, spec.shear).matrices(mechanism, pose)
        K, M = (matrix.toarray() for matrix in pair)
    values, x = scipy.linalg.eigh(K, M, subset_by_index=(0, count - 1))
    y = np.abs(x)
    entries = (y * (np.abs(K) @ y)).sum(axis=0) + values * (y * (np.abs(M) @ y)).sum(axis=0)
    mass = (x * (M @ x)).sum(axis=0)
    terms = 6 * (spec.elements + 1)
    return np.asarray(terms * np.finfo(float).eps * entries / (2 * values * mass))


def _analytic(checked: Checked) -> Iterator[Spec]:
    """Yield the models whose bounds are known: three elements, and none."""
    for spec in checked.plan.everywhere:
        if (spec.name in BEAMS or isinstance(spec, Formulation)) and spec.elements in (3, None):
            yield spec


def _worst(
    name: str, model: str, found: Sequence[tuple[str, Floats, Floats]], remark: str
) -> Iterator[Property]:
    """Yield the property at its worst: `found` holds case, deviations and bounds, mode by mode."""
    if not found:
        return
    ratios = [deviation / bound for _, deviation, bound in found]
    case, deviation, bound = found[int(np.argmax([ratio.max() for ratio in ratios]))]
    i = int(np.argmax(deviation / bound))
    yield Property(name, model, case, i + 1, float(deviation[i]), float(bound[i]), remark)


def _equivalents(checked: Checked) -> Iterator[Property]:
    study = checked.cases
    for spec in _analytic(checked):
        model = spec.build()
        for equivalent in UNITS:
            found = []
            for case in study.cases:
                f = study.modes[case.name, spec.label].frequencies[: study.count]
                changed = equivalent.change(case.mechanism, case.pose)
                again = model.modes(*changed, study.count + SPARE).frequencies[: study.count]
                deviation = np.abs(again / equivalent.factor / f - 1)
                # Rounding depends on the units: the bound is that of the changed problem.
                bound = np.maximum(
                    rounding(spec, case.mechanism, case.pose, study.count),
                    rounding(spec, *changed, study.count),
                )
                found.append((case.name, deviation, bound))
            yield from _worst(equivalent.name, spec.label, found, "rounding")


def _symmetry(checked: Checked) -> Iterator[Property]:
    """Equal limbs 120 degrees apart: turning the azimuth by as much changes nothing."""
    study = checked.workspace
    for spec in study.specs:
        groups: dict[tuple[float, float, float], list[Case]] = {}
        for case in study.cases:
            turn = round(float(np.degrees(case.pose.azimuth)) % 120, 6) % 120
            groups.setdefault((case.pose.z, case.pose.tilt, turn), []).append(case)
        found = []
        for first, *others in groups.values():
            solved = [study.get(case, spec) for case in (first, *others)]
            f = [modes.frequencies[: study.count] for modes in solved if modes is not None]
            if len(f) < 2:
                continue
            if spec.analytic:
                bound = rounding(spec, first.mechanism, first.pose, study.count)
            else:
                bound = np.full(study.count, DIFFERENCES.get(spec.name, MULTIBODY))
            for case, turned in zip(others, f[1:], strict=False):
                found.append((place(case), np.abs(turned / f[0] - 1), bound))
        remark = "rounding" if spec.analytic else "rounding of the simulator's matrices"
        yield from _worst("120 deg symmetry", spec.label, found, remark)


def _formulations(checked: Checked) -> Iterator[Property]:
    """The same elements in other formulations and by another eigen-solver."""
    study = checked.cases
    named = {spec.label: spec for spec in checked.plan.everywhere}
    paper = named.get("euler-bernoulli@3")
    if paper is None:
        return
    bounds = {
        case.name: rounding(paper, case.mechanism, case.pose, study.count) for case in study.cases
    }
    f = {
        case.name: study.modes[case.name, paper.label].frequencies[: study.count]
        for case in study.cases
    }
    others: dict[str, Any] = {"sparse solver = dense": Substructure(3, solver="sparse")}
    if "multipliers@3" in named:
        others["multipliers = substructure"] = named["multipliers@3"].build()
    for name, model in others.items():
        found = []
        for case in study.cases:
            other = model.modes(case.mechanism, case.pose, study.count + SPARE)
            deviation = np.abs(other.frequencies[: study.count] / f[case.name] - 1)
            found.append((case.name, deviation, 2 * bounds[case.name]))
        yield from _worst(name, paper.label, found, "rounding of both")


def _batch(checked: Checked) -> Iterator[Property]:
    """Condensed, at every pose at once, against the model itself, pose by pose."""
    for study in (checked.cases, checked.workspace):
        poses = [case.pose for case in study.cases]
        many = Pose(*(np.array([getattr(p, x) for p in poses]) for x in Pose.__match_args__))
        for spec in study.specs:
            if not spec.analytic or spec.elements not in (3, None):
                continue
            elements = spec.elements if isinstance(spec.elements, int) else None
            table = condensed_frequencies(
                study.cases[0].mechanism, many, elements, beam=spec.name, count=study.count
            )
            found = []
            for case, batch in zip(study.cases, table, strict=True):
                f = study.modes[case.name, spec.label].frequencies[: study.count]
                bound = BATCH + rounding(spec, case.mechanism, case.pose, study.count)
                found.append((place(case), np.abs(batch / f - 1), bound))
            over = GATE if study is checked.workspace else "cases"
            name = f"condensed = pose by pose, {over}"
            yield from _worst(name, spec.label, found, "the batch solver's 1e-9")


def _limits(checked: Checked) -> Iterator[Property]:
    """s -> infinity is the model without elements, which lies below any of them if conforming."""
    study = checked.cases
    exact = {spec.name: spec for spec in checked.plan.specs if spec.elements is None}
    for ladder in checked.plan.ladders:
        name = ladder[0].name
        if name not in exact:
            continue
        within, above = [], []
        elements = [n for spec in ladder if isinstance(n := spec.elements, int)]
        for case in study.cases:
            limit = study.modes[case.name, exact[name].label].frequencies[: study.count]
            f = np.array(
                [study.modes[case.name, s.label].frequencies[: study.count] for s in ladder]
            )
            seen = [verify(elements, f[:, i].tolist(), formal_order(ladder[0]))
                    for i in range(study.count)]  # fmt: skip
            off = np.abs(np.array([one.limit for one in seen]) / limit - 1)
            within.append((case.name, off, np.array([one.gci for one in seen]) / limit))
            slack = rounding(ladder[-1], case.mechanism, case.pose, study.count) + BRACKETS
            above.append((case.name, np.maximum(1 - f / limit, 0).max(axis=0), slack))
        yield from _worst("s -> infinity is exact", name, within, "the band of the finest mesh")
        if name != "timoshenko":  # whose elements are not conforming
            yield from _worst("elements only stiffen", name, above, "rounding")


def _theories(checked: Checked) -> Iterator[Property]:
    """Euler-Bernoulli > Rayleigh > Timoshenko; without shear Timoshenko is Rayleigh."""
    study = checked.cases
    exact = {spec.name: spec for spec in checked.plan.specs if spec.elements is None}
    for stiff, soft in (("euler-bernoulli", "rayleigh"), ("rayleigh", "timoshenko")):
        if not {stiff, soft} <= exact.keys():
            continue
        found = []
        for case in study.cases:
            high, low = (
                study.modes[case.name, exact[name].label].frequencies[: study.count]
                for name in (stiff, soft)
            )
            found.append((case.name, np.maximum(low / high - 1, 0), np.full(study.count, BRACKETS)))
        yield from _worst(f"{stiff} above {soft}", exact[soft].label, found, "no excess")
    if not {"rayleigh", "timoshenko"} <= exact.keys():
        return
    found = []
    for case in study.cases:
        f, sheared = (
            study.modes[case.name, exact[name].label].frequencies[: study.count]
            for name in ("rayleigh", "timoshenko")
        )
        model = replace(exact["timoshenko"], shear=STIFF).build()
        rigid = model.modes(case.mechanism, case.pose, study.count + SPARE)
        rod = case.mechanism.limbs[0].rod
        ratio = Theory("timoshenko").shear_coefficient(rod.material) / STIFF
        # The effect falls in proportion to 1 / kappa, or faster.
        bound = BRACKETS + 2 * (f / sheared - 1) * ratio
        found.append((case.name, np.abs(rigid.frequencies[: study.count] / f - 1), bound))
    yield from _worst("kappa -> infinity is rayleigh", exact["timoshenko"].label, found, "1/kappa")


def _massless(checked: Checked) -> Iterator[Property]:
    """Limbs without mass are springs: a rigid body on six of them, solved without a beam."""
    study = checked.cases
    light = with_material(lambda m: Material(m.young, m.shear, LIGHT * m.density))
    for spec in checked.plan.specs:
        if spec.elements is not None or not spec.analytic:
            continue
        model, found = spec.build(), []
        for case in study.cases:
            springs, shares = _springs(spec, case)
            mechanism, pose = light(case.mechanism, case.pose)
            f = model.modes(mechanism, pose, len(springs)).frequencies
            deviation = np.abs(f / springs - 1)
            # By Rayleigh's quotient: a limb moves no more than its end.
            bound = np.full(len(springs), BRACKETS + LIGHT * shares / 2)
            found.append((case.name, deviation, bound))
        yield from _worst("limbs without mass", spec.label, found, "the mass left")


def _springs(spec: Spec, case: Case) -> tuple[Floats, float]:
    """Return the platform's frequencies on static limbs (6,) [Hz], and the limbs' share of mass.

    A limb resists along itself, EA / L, and across in the plane of its revolute axis,
    1 / (L^3 / 3 EI + L / kappa G A).
    """
    limbs = limbs_at(case.mechanism, case.pose)
    M = platform_mass(case.mechanism, case.pose)
    theory = Theory(spec.name, spec.shear)
    K, share = np.zeros((6, 6)), 0.0
    for limb, L, arm, frame in zip(
        case.mechanism.limbs, limbs.lengths, limbs.arms, limbs.frames, strict=True
    ):
        rod, steel = limb.rod, limb.rod.material
        EI = steel.young * rod.second_moment
        across = 1 / (L**3 / (3 * EI) + theory.shear_flexibility(rod) * L / (12 * EI))
        J = rigid_arm(arm)
        for stiffness, direction in ((steel.young * rod.area / L, 2), (across, 1)):
            a = J.T @ frame[:, direction]
            K += stiffness * np.outer(a, a)
        mass = steel.density * rod.area * L
        # Rotary inertia at most doubles what a rod's motion weighs here: (d / 4 L)^2 << 1.
        share += 2 * mass * np.linalg.eigvalsh(J @ np.linalg.solve(M, J.T))[-1]
    return np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True)) / (2 * np.pi), float(share)


def _counts(checked: Checked) -> Iterator[Property]:
    """No mode missing, none too many: Wittrick and Williams count as many as were found."""
    study = checked.cases
    for spec in checked.plan.specs:
        if spec.elements is not None or not spec.analytic:
            continue
        theory = Continuum(spec.name, spec.shear)
        found = []
        for case in study.cases:
            f = study.modes[case.name, spec.label].frequencies
            number = np.arange(1, study.count + 1)
            counts = [
                (theory.count_below(case.mechanism, case.pose, one * (1 - 1e-9)),
                 theory.count_below(case.mechanism, case.pose, one * (1 + 1e-9)))
                for one in f[: study.count].tolist()
            ]  # fmt: skip
            below, upto = np.array(counts).T
            # The k-th mode: fewer than k below it, at least k up to it.
            off = np.maximum(np.maximum(below - (number - 1), number - upto), 0)
            found.append((case.name, off.astype(float), np.full(study.count, 0.5)))
        yield from _worst("Wittrick-Williams count", spec.label, found, "modes")
