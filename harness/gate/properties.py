"""What must hold without any baseline: one answer however it is asked for, and what is true.

True are limits, the order of theories, massless limbs, mode counts. Every bound is derived: from
the rounding of the matrices, from the width of certified brackets, from the limit itself, or from
the precision that a model declares.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray

from analytic import Continuum, Limb, Modes, limbs_at
from analytic.pairing import pair
from analytic.substructure import platform_mass, rigid_arm
from analytic.theory import LEAST_SHEAR, Theory
from harness.bench import SPARE
from harness.case import Case
from harness.causes import THEORIES
from harness.declared import moving
from harness.gate.equivalents import (
    SAME_ANSWERS,
    Seen,
    answer,
    posed,
    precision,
    relative,
    rounding,
    seen,
    solved,
)
from harness.gate.figures import Finding
from harness.gate.plan import MODES, Checked
from harness.presets import CONFORMING
from harness.signatures import Array
from harness.studies.refinement import MESHES, WARY, verify
from reference_models import Named

LIGHT, STIFF = 1e-9, 1 / LEAST_SHEAR
"""Density of limbs without mass, part of their own; the largest shear coefficient there is."""
SHORTER = (0.5, 0.45, 0.4)
"""Heights, of a case's own, at which a limb may twist among the lowest modes."""
BESIDE = 1e-9
"""How far from a root, relative, modes are counted."""
NO_MODE = np.full(MODES, 0.5)
"""Whole numbers of modes are off by none."""


def properties(checked: Checked) -> list[Finding]:
    """Return every property that the models solved in `checked` can show, each at its worst."""
    found: dict[tuple[str, str], Seen] = {}
    truths = (_limits, _extrapolated, _assumptions, _theories, _massless, _exact_counts, _torsion)
    for ask in (*SAME_ANSWERS, *truths):
        for ratio, one in ask(checked):
            key = one.quantity, one.model
            if key not in found or ratio > found[key][0]:
                found[key] = ratio, one
    return [one for _, one in found.values()]


def _exact(checked: Checked) -> Iterator[tuple[Named, Theory, Case]]:
    """Yield the models without elements that were solved, with their exact theories and cases."""
    for one in checked.plan.singles:
        if one.elements is None and (limit := one.limit()):
            theory = Theory(limit.name, dict(limit.settings).get("shear", "cowper"))
            yield from ((one, theory, case) for case in checked.cases.complete(one))


def _truth(
    checked: Checked, *models: Named
) -> Iterator[tuple[Case, Array, Array, list[Modes], NDArray[np.intp]]]:
    """Yield every case with its exact frequencies, as they are and with 1 for 0, the answers of
    `models`, and the partner of each exact mode in each answer.

    The exact model is that of the theory that the first model declares; none where there is none.
    """
    limit, study = models[0].limit(), checked.cases
    if limit is None:
        return
    exact = checked.bench.run(study.cases, [limit], MODES)
    for case in study.complete(*models):
        if modes := exact.first(case, limit):
            f, own = modes.frequencies, [study.answers[case, model] for model in models]
            partners = [pair(modes, one, case.mechanism, case.pose).partner for one in own]
            yield case, f, np.where(f > 0, f, 1.0), own, np.array(partners)


def _limits(checked: Checked) -> Iterator[Seen]:
    """s -> infinity is the exact model of the theory that is declared.

    That lies below every mesh if the elements are conforming.
    """
    for ladder in checked.plan.ladders:
        name, limit = ladder[0].name, ladder[0].limit()
        if len(ladder) < 2 or limit is None:
            continue
        for case, exact, scale, meshes, partners in _truth(checked, *ladder):
            f = np.array([m.frequencies[p] for m, p in zip(meshes, partners, strict=True)])
            value, band = _converged(ladder, f)
            slack = rounding(case, ladder[-1], limit)
            off, bound = relative(value, exact), band / scale + slack
            told = "the band of the finest mesh"
            yield seen("s -> infinity is exact", name, told, case, off, bound)
            if name in CONFORMING:
                short = np.maximum(1 - f / scale, 0).max(axis=0) * (exact > 0)
                yield seen("elements only stiffen", name, "rounding", case, short, slack)


def _converged(ladder: Sequence[Named], f: Array) -> tuple[Array, Array]:
    """Return the limits of `f` (meshes, modes) and the half-widths of their bands [Hz].

    Of two meshes by the formal order, with the factor of a band that nothing confirms.
    """
    elements = [n for one in ladder if isinstance(n := one.elements, int)]
    order = ladder[0].info().order
    if len(ladder) < MESHES:
        step = (f[-1] - f[-2]) / ((elements[-1] / elements[-2]) ** order - 1)
        return f[-1] + step, WARY * np.abs(step)
    columns = [verify(elements, column.tolist(), order) for column in f.T]
    return np.array([one.limit for one in columns]), np.array([one.gci for one in columns])


def _extrapolated(checked: Checked) -> Iterator[Seen]:
    """What is extrapolated from two meshes lies as near the exact model as it says."""
    for model in checked.plan.singles:
        if not isinstance(model.elements, tuple):
            continue
        for case, exact, scale, (own,), (partner,) in _truth(checked, model):
            if own.uncertainty is not None:
                off = relative(own.frequencies[partner], exact)
                bound = own.uncertainty[partner] / scale + rounding(case, model)
                yield seen("extrapolated is exact", model, "its own uncertainty", case, off, bound)


def _assumptions(checked: Checked) -> Iterator[Seen]:
    """Without an assumption that holds something rigid, no frequency is higher."""
    study = checked.cases
    for ladder in checked.plan.ladders:
        model, info = ladder[0], ladder[0].info()
        if not info.relaxed or info.relaxed in checked.plan.skipped:
            continue
        relaxed = Named(info.relaxed, model.elements)
        if relaxed.info().program != info.program:
            continue  # on other meshes
        for case in study.complete(model):
            low = answer(checked.bench, relaxed, case)
            if np.isfinite(low).all():
                off, bound = low / solved(study, case, model) - 1, rounding(case, model)
                name = f"{info.assumption} only stiffens"
                yield seen(name, model, "no excess", case, np.maximum(off, 0), bound)


def _theories(checked: Checked) -> Iterator[Seen]:
    """Euler-Bernoulli > Rayleigh > Timoshenko; without shear Timoshenko is Rayleigh."""
    study = checked.cases
    exact = {one.name: one for one in checked.plan.singles if one.elements is None}
    chain = [exact[name] for name in THEORIES if name in exact]
    for stiff, soft in pairwise(chain):
        for case in study.complete(stiff, soft):
            off = solved(study, case, soft) / solved(study, case, stiff) - 1
            name, bound = f"{stiff.name} above {soft.name}", rounding(case, soft)
            yield seen(name, soft, "no excess", case, np.maximum(off, 0), bound)
    if not {*THEORIES[-2:]} <= exact.keys():
        return
    without, sheared = chain[-2:]
    stiffest = Named(sheared.name, None, (("shear", STIFF),))
    for case in study.complete(without, sheared):
        if case.mechanism.simple:
            f = solved(study, case, without)
            off = relative(answer(checked.bench, stiffest, case), f)
            kappa = Theory(sheared.name).shear_coefficient(case.mechanism.limbs[0].rod.material)
            # The effect falls in proportion to 1 / kappa, or faster.
            effect = 2 * (f / solved(study, case, sheared) - 1) * kappa / STIFF
            name, bound = f"kappa -> infinity is {without.name}", rounding(case, without) + effect
            yield seen(name, sheared, "1/kappa", case, off, bound)


def _massless(checked: Checked) -> Iterator[Seen]:
    """Limbs without mass are springs: a rigid body on them, solved without a beam."""
    for model, theory, case in _exact(checked):
        if case.mechanism.simple:
            springs, shares = _springs(theory, case)
            limbs = tuple(map(_light, case.mechanism.limbs))
            light = posed(case, replace(case.mechanism, limbs=limbs), case.pose)
            off = relative(answer(checked.bench, model, light), springs)
            # By Rayleigh's quotient: a limb moves no more than its end.
            bound = precision(model, case) + LIGHT * shares / 2
            yield seen("limbs without mass", model, "the mass left", case, off, bound)


def _light(limb: Limb) -> Limb:
    rod, steel = limb.rod, limb.rod.material
    return limb.with_rod(replace(rod, material=replace(steel, density=LIGHT * steel.density)))


def _springs(theory: Theory, case: Case) -> tuple[Array, float]:
    """Return the platform's frequencies on static limbs (6,) [Hz], and the limbs' share of mass.

    A limb resists along itself, EA / L, and across in the plane of its revolute axis,
    1 / (L^3 / 3 EI + L / kappa G A).
    """
    limbs = limbs_at(case.mechanism, case.pose)
    M = platform_mass(case.mechanism, case.pose)
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
    values = scipy.linalg.eigh(K, M, eigvals_only=True)
    return np.sqrt(np.maximum(values, 0)) / (2 * np.pi), float(share)


def _exact_counts(checked: Checked) -> Iterator[Seen]:
    """No mode missing, none too many: Wittrick and Williams count as many as were found."""
    number = np.arange(1, MODES + 1)
    for model, theory, case in _exact(checked):
        count = Continuum(theory.beam, theory.shear).count_below
        f = solved(checked.cases, case, model)
        below, upto = (
            np.array([one and count(case.mechanism, case.pose, one) for one in beside.tolist()])
            for beside in (f * (1 - BESIDE), f * (1 + BESIDE))
        )
        # The k-th mode: fewer than k below it, at least k up to it; free motion has no below.
        off = np.maximum(below - (number - 1), number - upto) * (f > 0)
        yield seen("Wittrick-Williams count", model, "modes", case, np.maximum(off, 0.0), NO_MODE)


def _torsion(checked: Checked) -> Iterator[Seen]:
    """Rods twist or do not, as declared: shorter limbs do so among their lowest modes.

    There the bench refuses modes of torsion that are not declared, and misses those that are.
    """
    solve = checked.bench.solve
    for *_, model in checked.plan.ladders:
        limit = model.limit()
        if limit is None:
            continue
        for case in checked.cases.complete(model):
            for pose in (replace(case.pose, z=part * case.pose.z) for part in SHORTER):
                exact = solve(limit, case.mechanism, pose, MODES)
                if isinstance(exact, Modes) and not moving(exact, case.mechanism, pose).all():
                    ours = solve(model, case.mechanism, pose, MODES + SPARE)
                    off = np.full(MODES, 0.0 if isinstance(ours, Modes) else np.inf)
                    yield seen("rods twist as declared", model.name, "modes", case, off, NO_MODE)
                    break
