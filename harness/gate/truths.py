"""What is true of the problem itself: limits, the order of theories, massless limbs, counts."""

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
from harness.bench import SPARE, Bench, label
from harness.case import Case
from harness.causes import THEORIES
from harness.declared import moving
from harness.gate.equivalents import answer, relative
from harness.gate.plan import MODES, Checked
from harness.gate.properties import Seen, precision, rounding, solved
from harness.presets import CONFORMING
from harness.studies.refinement import MESHES, WARY, verify
from reference_models import Named

Floats = NDArray[np.float64]
LIGHT, STIFF = 1e-9, 1 / LEAST_SHEAR
"""Density of limbs without mass, part of their own; the largest shear coefficient there is."""
SHORTER = (0.5, 0.45, 0.4)
"""Heights, of a case's own, at which a limb may twist among the lowest modes."""
BESIDE = 1e-9
"""How far from a root, relative, modes are counted."""


def truths(checked: Checked, bench: Bench) -> Iterator[Seen]:
    """Yield what the models solved in `checked` must meet, whatever they met before."""
    yield from _limits(checked, bench)
    yield from _extrapolated(checked, bench)
    yield from _assumptions(checked, bench)
    yield from _theories(checked, bench)
    yield from _massless(checked, bench)
    yield from _exact_counts(checked)
    yield from _torsion(checked, bench)


def _exact(checked: Checked) -> list[Named]:
    """Return the models without elements that were solved, of theories with an exact limit."""
    return [one for one in checked.plan.singles if one.elements is None and one.limit() is not None]


def _theory(model: Named) -> Theory:
    """Return the theory of a model with a limit."""
    limit = model.limit()
    assert limit is not None, "asked of models with a limit only"
    return Theory(limit.name, dict(limit.settings).get("shear", "cowper"))


def _truth(
    checked: Checked, bench: Bench, *models: Named
) -> Iterator[tuple[Case, Modes, list[Modes], Floats]]:
    """Yield every case with its exact modes, those of `models`, and the exact frequencies, none 0.

    The exact model is that of the theory that the first model declares; none where there is none.
    """
    limit, study = models[0].limit(), checked.cases
    if limit is None:
        return
    exact = bench.run(study.cases, [limit], MODES)
    for case in study.complete(*models):
        modes = exact.first(case, limit)
        if modes is not None:
            f = modes.frequencies
            yield case, modes, [study.answers[case, m] for m in models], np.where(f > 0, f, 1.0)


def _limits(checked: Checked, bench: Bench) -> Iterator[Seen]:
    """s -> infinity is the exact model of the theory that is declared.

    That lies below every mesh if the elements are conforming.
    """
    for ladder in checked.plan.ladders:
        if len(ladder) < 2:
            continue
        name = ladder[0].name
        for case, exact, meshes, scale in _truth(checked, bench, *ladder):
            limit = ladder[0].limit()
            assert limit is not None, "there is a truth"
            partners = (pair(exact, one, case.mechanism, case.pose).partner for one in meshes)
            f = np.array([m.frequencies[p] for m, p in zip(meshes, partners, strict=True)])
            value, band = _converged(ladder, f)
            slack = rounding(case, ladder[-1], limit)
            off = relative(value, exact.frequencies)
            yield Seen("s -> infinity is exact", name, "the band of the finest mesh", case.name,
                       off, band / scale + slack)  # fmt: skip
            if name in CONFORMING:
                short = np.maximum(1 - f / scale, 0).max(axis=0) * (exact.frequencies > 0)
                yield Seen("elements only stiffen", name, "rounding", case.name, short, slack)


def _converged(ladder: Sequence[Named], f: Floats) -> tuple[Floats, Floats]:
    """Return the limits of `f` (meshes, modes) and the half-widths of their bands [Hz].

    Of two meshes by the formal order, with the factor of a band that nothing confirms.
    """
    elements = [n for one in ladder if isinstance(n := one.elements, int)]
    order = ladder[0].info().order
    if len(ladder) < MESHES:
        step = (f[-1] - f[-2]) / ((elements[-1] / elements[-2]) ** order - 1)
        return f[-1] + step, WARY * np.abs(step)
    seen = [verify(elements, column.tolist(), order) for column in f.T]
    return np.array([one.limit for one in seen]), np.array([one.gci for one in seen])


def _extrapolated(checked: Checked, bench: Bench) -> Iterator[Seen]:
    """What is extrapolated from two meshes lies as near the exact model as it says."""
    for model in checked.plan.singles:
        if not isinstance(model.elements, tuple):
            continue
        for case, exact, (own,), scale in _truth(checked, bench, model):
            if own.uncertainty is not None:
                partner = pair(exact, own, case.mechanism, case.pose).partner
                off = relative(own.frequencies[partner], exact.frequencies)
                bound = own.uncertainty[partner] / scale + rounding(case, model)
                yield Seen("extrapolated is exact", label(model), "its own uncertainty", case.name,
                           off, bound)  # fmt: skip


def _assumptions(checked: Checked, bench: Bench) -> Iterator[Seen]:
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
            low = answer(bench, relaxed, case.mechanism, case.pose, MODES)
            if np.isfinite(low).all():
                off = np.maximum(low / solved(study, case, model) - 1, 0)
                yield Seen(f"{info.assumption} only stiffens", label(model), "no excess", case.name,
                           off, rounding(case, model))  # fmt: skip


def _theories(checked: Checked, bench: Bench) -> Iterator[Seen]:
    """Euler-Bernoulli > Rayleigh > Timoshenko; without shear Timoshenko is Rayleigh."""
    study = checked.cases
    exact = {one.name: one for one in checked.plan.singles if one.elements is None}
    chain = [exact[name] for name in THEORIES if name in exact]
    for stiff, soft in pairwise(chain):
        for case in study.complete(stiff, soft):
            off = np.maximum(solved(study, case, soft) / solved(study, case, stiff) - 1, 0)
            yield Seen(f"{stiff.name} above {soft.name}", label(soft), "no excess", case.name, off,
                       rounding(case, soft))  # fmt: skip
    if not {*THEORIES[-2:]} <= exact.keys():
        return
    without, sheared = chain[-2:]
    stiffest = Named(sheared.name, None, (("shear", STIFF),))
    for case in study.complete(without, sheared):
        if not case.mechanism.simple:
            continue
        f = solved(study, case, without)
        off = relative(answer(bench, stiffest, case.mechanism, case.pose, MODES), f)
        kappa = Theory(sheared.name).shear_coefficient(case.mechanism.limbs[0].rod.material)
        # The effect falls in proportion to 1 / kappa, or faster.
        effect = 2 * (f / solved(study, case, sheared) - 1) * kappa / STIFF
        yield Seen(f"kappa -> infinity is {without.name}", label(sheared), "1/kappa", case.name,
                   off, rounding(case, without) + effect)  # fmt: skip


def _massless(checked: Checked, bench: Bench) -> Iterator[Seen]:
    """Limbs without mass are springs: a rigid body on them, solved without a beam."""
    for model in _exact(checked):
        for case in checked.cases.complete(model):
            if not case.mechanism.simple:
                continue
            springs, shares = _springs(_theory(model), case)
            light = replace(case.mechanism, limbs=tuple(map(_light, case.mechanism.limbs)))
            f = answer(bench, model, light, case.pose, len(springs))
            # By Rayleigh's quotient: a limb moves no more than its end.
            bound = precision(model, case.mechanism, case.pose, len(springs)) + LIGHT * shares / 2
            yield Seen("limbs without mass", label(model), "the mass left", case.name,
                       relative(f, springs), bound)  # fmt: skip


def _light(limb: Limb) -> Limb:
    rod, steel = limb.rod, limb.rod.material
    return limb.with_rod(replace(rod, material=replace(steel, density=LIGHT * steel.density)))


def _springs(theory: Theory, case: Case) -> tuple[Floats, float]:
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
    study, number = checked.cases, np.arange(1, MODES + 1)
    for model in _exact(checked):
        theory = _theory(model)
        count = Continuum(theory.beam, theory.shear).count_below
        for case in study.complete(model):
            f = solved(study, case, model)
            below, upto = (
                np.array([one and count(case.mechanism, case.pose, one) for one in beside.tolist()])
                for beside in (f * (1 - BESIDE), f * (1 + BESIDE))
            )
            # The k-th mode: fewer than k below it, at least k up to it; free motion has no below.
            off = np.maximum(below - (number - 1), number - upto) * (f > 0)
            yield _counted("Wittrick-Williams count", label(model), case, np.maximum(off, 0.0))


def _torsion(checked: Checked, bench: Bench) -> Iterator[Seen]:
    """Rods twist or do not, as declared: shorter limbs do so among their lowest modes.

    There the bench refuses modes of torsion that are not declared, and misses those that are.
    """
    for *_, model in checked.plan.ladders:
        limit = model.limit()
        if limit is None:
            continue
        for case in checked.cases.complete(model):
            for pose in (replace(case.pose, z=part * case.pose.z) for part in SHORTER):
                exact = bench.solve(limit, case.mechanism, pose, MODES)
                if isinstance(exact, Modes) and not moving(exact, case.mechanism, pose).all():
                    ours = bench.solve(model, case.mechanism, pose, MODES + SPARE)
                    off = np.array([0.0 if isinstance(ours, Modes) else np.inf])
                    yield _counted("rods twist as declared", model.name, case, off)
                    break


def _counted(name: str, model: str, case: Case, off: Floats) -> Seen:
    """Return a property of whole numbers of modes, which are `off` by none."""
    return Seen(name, model, "modes", case.name, off, np.full(len(off), 0.5))
