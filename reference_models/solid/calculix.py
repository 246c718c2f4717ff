"""`calculix-solid`: the limbs as three-dimensional elastic bodies, by CalculiX."""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError, number
from analytic.errors import count as whole
from analytic.mechanism import Mechanism, Rod
from analytic.model import Info
from analytic.modes import STATIONS, Modes
from analytic.pose import Pose
from reference_models.projection import STILL, vibrations
from reference_models.protocol import ModelError, UnavailableError, hertz
from reference_models.solid.calculix_deck import Deck, write
from reference_models.solid.calculix_run import MISSING, NAME, Answer, program, run, version
from reference_models.solid.rod_mesh import RodMesh
from reference_models.spent import phase
from reference_models.units import in_robot_units

Array = NDArray[np.float64]

THEORY = "3-D elasticity, rigid end faces"
ORDER = 4
ELEMENTS = ("C3D20R", "C3D20")
GRADING = 2.5
"""Stress at the rim of a clamped face grows as r^-0.29 (90 degree corner, Poisson's ratio 0.3): on
equal elements frequencies would converge as h^1.4. With distances to the rim as the power 2.5 of
the element's number, the rim's share falls as h^3.6, and h^4, the element's own order, is seen."""
FAR = 2.0**20
"""Over the time that a wave takes along a limb: ccx finds the modes nearest to omega^2 = 1,
whatever the unit of time. In this one even thin rods have all of theirs far above."""
PRINTED = 1e-5
"""Displacements are printed to seven digits: what is joined must agree to this, relative."""


@dataclass(frozen=True)
class CalculixSolid:
    """Solid rods of 20-node hexahedra, `elements` along each; CalculiX's own rigid bodies.

    Across a rod there are a quarter as many (rounded up) in its core's side and in the rings
    around it, across a tube so many rings: refinement is uniform for multiples of four. End faces,
    bodies and platform are rigid; joints are equations between their reference nodes. `element` is
    C3D20R (reduced integration) or C3D20 (full: stiffer); ccx is stopped after `time_limit` [s].
    Raises `InputError` for fewer than two elements, or a setting that is none.
    """

    elements: int = 8
    element: str = "C3D20R"
    time_limit: float = 120.0

    def __post_init__(self) -> None:
        whole("elements", self.elements, at_least=2)
        number("time_limit", self.time_limit, "a positive number of seconds", positive=True)
        if self.element not in ELEMENTS:
            raise InputError("element", self.element, f"one of {', '.join(ELEMENTS)}")

    @classmethod
    def info(cls) -> Info:
        """Return what the model is; never raises."""
        remark = (
            "stress is singular at the clamped rims, where equal elements converge slowly (order "
            "1.5); crowded towards rims and end faces, order 4 is observed"
        )
        try:
            installed, missing = version(program()), ""
        except UnavailableError:
            installed, missing = "", MISSING
        return Info(
            THEORY,
            "CalculiX",
            installed,
            ORDER,
            (8, 12),
            (4, 6, 8),
            relaxed="ngsolve-averaged",
            assumption="rigid end faces",
            remark=remark,
            missing=missing,
            slow=True,
            precision=2e-6,  # of seven printed digits
        )

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose.

        Limbs of any chain of round rods and tubes are taken; motions of a limb's own that need no
        energy are left out. Raises `InputError` for a pose out of reach, a limb without rods, a rod
        that is not round or more modes than coordinates, and as `calculix_run.run`; `ModelError`
        also where a joint is open.
        """
        return in_robot_units(NAME, self._solve, mechanism, pose, count, FAR, chains=True)

    def _solve(self, mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        begin = time.perf_counter()
        with phase("building"):
            deck = write(mechanism, pose, self._mesh, self.element, count)
            residual = deck.gap()
        built = time.perf_counter()
        answer = run(deck.text, self.time_limit)
        solved = time.perf_counter()
        with phase("shapes"):
            kept = check_answer(answer, deck, count)
            platform = answer.at(np.array(deck.platform))[kept].reshape(count, 6)
            limbs = centre_lines(answer, deck)[kept]
        return Modes(
            frequencies=np.sqrt(answer.eigenvalues[kept]) / (2 * np.pi),
            platform=platform,
            limbs=limbs,
            theory=THEORY,
            model=NAME,
            version=f"ccx {version(program())}",
            elements=self.elements,
            dofs=answer.equations,
            residual=residual,
            build_seconds=built - begin,
            solve_seconds=solved - built,
        )

    def _mesh(self, rod: Rod, length: float) -> RodMesh:
        across, own = -(-self.elements // 4), rod.section
        assert own.diameter is not None
        return RodMesh(length, own.diameter, self.elements, across, GRADING, own.bore)


def centre_lines(answer: Answer, deck: Deck) -> Array:
    """Return the displacement of the limbs' centre lines at `STATIONS`, shape (m, n, 11, 3)."""
    found = np.zeros((len(answer.eigenvalues), len(deck.lines), len(STATIONS), 3))
    for i, limb in enumerate(deck.lines):
        for line in limb:
            moved = np.einsum("sk,mskx->msx", line.weights, answer.at(line.nodes))
            if line.beyond is not None:
                moved += np.cross(answer.at(np.array(line.turn))[:, None, :], line.beyond)
            found[:, i, line.stations] = moved
    return found


def check_answer(answer: Answer, deck: Deck, count: int) -> NDArray[np.intp]:
    """Return which modes are the `count` lowest vibrations.

    Raises `ModelError` unless there are so many, and all keep the joints closed.
    """
    found = len(answer.eigenvalues) - (deck.spins or 0)
    if not np.array_equal(answer.nodes, deck.shown):
        raise ModelError(f"{NAME}: ccx did not print the displacements of all nodes asked for")
    if found != count:
        raise ModelError(f"{NAME}: ccx found {found} modes, {count} were asked for")
    ascending = answer.eigenvalues
    if not ascending[0 if deck.spins is None else -1] > 0 or not (np.diff(ascending) >= 0).all():
        reason = "negative or unsorted: does anything move freely?"
        raise ModelError(f"{NAME}: eigenvalues of ccx are {reason}")
    kept = np.arange(count)
    if deck.spins is not None:
        noise = (STILL**2) * ascending[-1]
        kept = vibrations(NAME, hertz(NAME, ascending, noise), deck.spins, count)
    opening = 0.0
    for terms in deck.equations:
        nodes, freedoms, factors = (np.array(part) for part in zip(*terms, strict=True))
        moved = answer.at(nodes)[:, np.arange(len(nodes)), freedoms - 1]
        opening = max(opening, float(np.abs(moved @ factors).max()))
    if not opening <= PRINTED * np.abs(answer.displacements).max():
        raise ModelError(f"{NAME}: a mode opens a joint, by {opening:.1e} m per sqrt(kg)")
    return kept
