"""Every way of this bench to solve a pose: methods, theories, simulators, and their elements."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import InputError, Modes, Multipliers, Pose, condensed_frequencies
from analytic.theory import BEAMS
from harness.cases import Case
from harness.models import MADE_FROM, PAPER_ELEMENTS, SOLID_LIMB, Spec, batch_solver, parse
from harness.precision.cost import random_poses
from harness.run import SPARE
from reference_models.protocol import find

Array = NDArray[np.float64]
COUNT = 6
BATCH = 100
"""Poses a call of the ways that take many at once."""
TRUTHS = ("calculix-solid", "ngsolve-solid")
EXTRA = 2 * SPARE
"""Modes solved for beyond COUNT, as extrapolation needs them."""


@dataclass(frozen=True)
class Way:
    """One way to solve `spec`: `solve` gives the modes, or frequencies, of a case at a pose.

    `kind`: "batch" (many poses a call), "single" or "simulator"; `poses` that one call solves.
    """

    method: str
    spec: Spec
    kind: str
    solve: Callable[[Case, Pose], Modes | Array]
    poses: int = 1


def theory_of(spec: Spec) -> str:
    """Return what the model converges to: the name of a beam theory, or a solid in words."""
    if spec.analytic:
        return spec.name
    theory = find(MADE_FROM if spec.name == SOLID_LIMB else spec.name).info().theory
    named = next((name for name, words in BEAMS.items() if theory == words), None)
    # What follows a second comma approximates the same solid: so many modes of a limb kept.
    return named or ",".join(theory.split(",")[:2])


def solid_truth() -> Spec | None:
    """Return the solid model that stands for the truth: the first of TRUTHS that can run here."""
    name = next((name for name in TRUTHS if not find(name).info().missing), None)
    return None if name is None else parse(name, "truth")


def every_way(steps: Sequence[int], references: Sequence[str]) -> tuple[list[Way], dict[str, str]]:
    """Return all ways, with `steps` elements where limbs are beams, and what was left out, why.

    Solids have elements of their own: half the coarser of the two they are extrapolated from, and
    these two.
    """
    ways: list[Way] = []
    for name in BEAMS:
        meshes, exact = [Spec(name, s) for s in steps], Spec(name, None)
        ways += [_built(f"substructure, {name}", spec) for spec in meshes]
        ways.append(_built(f"continuum, {name}", exact))
        ways += [_condensed(f"condensed, {name}", spec) for spec in (*meshes, exact)]
        many = f"condensed, {name}, {BATCH} poses a call"
        # Batches cost the same with any number of elements: the paper's and none will do.
        ways += [_batched(many, spec) for spec in (Spec(name, PAPER_ELEMENTS), exact)]
    for solver in ("null-space", "saddle-point"):
        for s in steps:
            solve = _modes(Multipliers(s, solver=solver))
            ways.append(Way(f"multipliers, {solver}", Spec("euler-bernoulli", s), "single", solve))
    left_out: dict[str, str] = {}
    for name in references:
        for n in _meshes(name, steps):
            try:
                ways.append(_built(name, Spec(name, n), "simulator"))
            except InputError as error:
                left_out[name] = f"not with {n} elements ({error})"
    if MADE_FROM in references:
        spec = parse(SOLID_LIMB, "references")
        ways.append(_built(SOLID_LIMB, spec))
        ways.append(_batched(f"{SOLID_LIMB}, {BATCH} poses a call", spec))
    return ways, left_out


def _meshes(name: str, steps: Sequence[int]) -> list[int]:
    if theory_of(Spec(name, None)) in BEAMS:
        return list(steps)
    coarse, fine = find(name).info().refinements
    return sorted({max(1, coarse // 2), coarse, fine})


def _modes(model: Any) -> Callable[[Case, Pose], Modes | Array]:
    return lambda case, pose: model.modes(case.mechanism, pose, COUNT + EXTRA)


def _built(method: str, spec: Spec, kind: str = "single") -> Way:
    return Way(method, spec, kind, _modes(spec.build()))


def _condensed(method: str, spec: Spec) -> Way:
    s = spec.elements if isinstance(spec.elements, int) else None

    def solve(case: Case, pose: Pose) -> Array:
        found = condensed_frequencies(case.mechanism, pose, s, count=COUNT + SPARE, beam=spec.name)
        return np.asarray(found).reshape(-1)

    return Way(method, spec, "single", solve)


def _batched(method: str, spec: Spec) -> Way:
    """Return a way that solves BATCH poses a call, the case's own first."""
    solver, others = batch_solver(spec), random_poses(BATCH - 1)
    assert solver is not None, "only models that take many poses are asked"

    def solve(case: Case, pose: Pose) -> Array:
        z, azimuth, tilt = (
            np.append(getattr(pose, name), getattr(others, name))
            for name in ("z", "azimuth", "tilt")
        )
        return np.asarray(solver(case.mechanism, Pose(z, azimuth, tilt), COUNT + SPARE)[0])

    return Way(method, spec, "batch", solve, BATCH)
