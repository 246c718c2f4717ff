"""`calculix-solid`: the limbs as three-dimensional elastic bodies, by CalculiX."""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError, number
from analytic.errors import count as whole
from analytic.mechanism import Mechanism
from analytic.model import Info
from analytic.modes import Modes
from analytic.pose import Pose
from reference_models import placement
from reference_models.exudyn.system import Axis
from reference_models.protocol import ModelError, UnavailableError
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
    """Solid rods of 20-node hexahedra, `elements` along a limb; CalculiX's own rigid bodies.

    Across a rod there are a quarter as many (rounded up) in its core's side and in the rings
    around it: refinement is uniform for multiples of four. End faces and platform are rigid;
    joints are equations between their reference nodes. `element` is C3D20R (reduced integration)
    or C3D20 (full: stiffer); ccx is stopped after `time_limit` [s].
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

        Raises `InputError` for a pose out of reach or more modes than coordinates, and as
        `calculix_run.run`; `ModelError` also where a joint is open.
        """
        return in_robot_units(NAME, self._solve, mechanism, pose, count, FAR)

    def _solve(self, mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        begin = time.perf_counter()
        with phase("building"):
            deck = write(mechanism, pose, self._mesh, self.element, count)
            residual = largest_gap(deck, mechanism)
        built = time.perf_counter()
        answer = run(deck.text, self.time_limit)
        solved = time.perf_counter()
        with phase("shapes"):
            check_answer(answer, deck, count)
            platform = answer.at(np.array(deck.platform)).reshape(count, 6)
            limbs = centre_lines(answer, deck)
        return Modes(
            frequencies=np.sqrt(answer.eigenvalues) / (2 * np.pi),
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

    def _mesh(self, axis: Axis) -> RodMesh:
        across = -(-self.elements // 4)
        return RodMesh(axis.length, axis.rod.diameter, self.elements, across, GRADING)


def largest_gap(deck: Deck, mechanism: Mechanism) -> float:
    """Return the largest distance between what a joint should hold together, in the deck [m].

    From the nodes as written: the start of each rod's centre line from B_i, its end from the
    platform's node at A_i, each face's reference node from both, and A_i from the plane of its
    revolute joint.
    """
    points = deck.points()
    gaps = []
    for rod, base, held in zip(deck.rods, mechanism.bases, deck.held, strict=True):
        line = np.einsum("sk,skx->sx", rod.weights, points[rod.nodes - 1])
        anchor, tip, point = points[[rod.anchor - 1, rod.tip - 1, held - 1]]
        gaps += [line[0] - base, anchor - base, line[-1] - point, tip - point]
    beside = placement.largest_gap(mechanism, points[deck.held - 1])
    return max(beside, float(np.linalg.norm(gaps, axis=1).max()))


def centre_lines(answer: Answer, deck: Deck) -> Array:
    """Return the displacement of the limbs' centre lines at `STATIONS`, shape (m, n, 11, 3)."""
    lines = [np.einsum("sk,mskx->msx", rod.weights, answer.at(rod.nodes)) for rod in deck.rods]
    return np.stack(lines, axis=1)


def check_answer(answer: Answer, deck: Deck, count: int) -> None:
    """Raise `ModelError` unless these are `count` modes that keep the joints closed."""
    found = len(answer.eigenvalues)
    if not np.array_equal(answer.nodes, deck.shown):
        raise ModelError(f"{NAME}: ccx did not print the displacements of all nodes asked for")
    if found != count:
        raise ModelError(f"{NAME}: ccx found {found} modes, {count} were asked for")
    if not (answer.eigenvalues > 0).all() or not (np.diff(answer.eigenvalues) >= 0).all():
        reason = "negative or unsorted: does anything move freely?"
        raise ModelError(f"{NAME}: eigenvalues of ccx are {reason}")
    tips = answer.at(np.array([rod.tip for rod in deck.rods]))
    anchors = answer.at(np.array([rod.anchor for rod in deck.rods]))
    opening = max(np.abs(tips - answer.at(deck.held)).max(), np.abs(anchors).max())
    if not opening <= PRINTED * np.abs(answer.displacements).max():
        raise ModelError(f"{NAME}: a mode opens a joint, by {opening:.1e} m per sqrt(kg)")
