"""`mujoco-chain`: limbs as chains of rigid segments, sprung against each other, in MuJoCo.

Plain bodies, joints and springs, the same in every MuJoCo version. The springs between two of n
segments of length h = L / n stand for the rod between their middles: EA / h to stretch, EI / h to
bend each way, G J / h to twist. Those at the ends stand for half of that and are twice as stiff.
They sit between the revolute joint and the first segment, but for bending about the joint's own
axis, and, to stretch only, between the last segment and A_i: no moment reaches either.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError
from analytic.errors import count as whole
from analytic.mechanism import Mechanism
from analytic.model import Info
from analytic.modes import Modes
from analytic.pose import Pose
from reference_models.mujoco import system
from reference_models.mujoco.rig import STILL, Limb, Rods, inertial, text

NAME = "mujoco-chain"
SHEARLESS = {"euler-bernoulli": "Euler-Bernoulli", "rayleigh": "Rayleigh"}


@dataclass(frozen=True)
class MujocoChain:
    """Limbs of `elements` rigid segments, closed at A_i by `connect` and exact projection.

    `beam` says what inertia a segment has about its diameters: "euler-bernoulli" that of a line,
    m h^2 / 12, or "rayleigh" that of the cylinder it is, m (h^2 / 12 + d^2 / 16). About its axis
    it has m d^2 / 8. Raises `InputError` for fewer than two elements or another `beam`.
    """

    elements: int = 16
    beam: str = "euler-bernoulli"

    def __post_init__(self) -> None:
        whole("elements", self.elements, at_least=2)
        if self.beam not in SHEARLESS:
            raise InputError("beam", self.beam, f"one of {', '.join(SHEARLESS)}")

    @classmethod
    def info(cls) -> Info:
        """Return what the model is; never raises."""
        return Info(
            SHEARLESS[cls.beam],
            "MuJoCo",
            system.installed(),
            2,
            (12, 24),
            (6, 12, 24),
            limit=cls.beam,
            remark='rigid segments and springs; Rayleigh with beam="rayleigh"',
            missing=system.missing(),
        )

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose; raises as `system.run`."""
        theory = SHEARLESS[self.beam]
        return system.run(
            NAME, theory, self.elements, self._rods, _stiffness, mechanism, pose, count
        )

    def _rods(self, limbs: list[Limb]) -> Rods:
        chains = [_chain(i, limb, self.elements) for i, limb in enumerate(limbs)]
        names = [[f"S{i}_{k}" for k in range(self.elements)] for i in range(len(limbs))]
        joints = "".join(f'<connect site1="T{i}" site2="A{i}"/>' for i in range(len(limbs)))

        def amend(model: Any) -> None:
            # The compiler refuses what is flatter than a disc, as a short segment without the
            # sections' rotary inertia is.
            for limb, segments in zip(limbs, names, strict=True):
                for name in segments:
                    model.body(name).inertia = self._moments(limb)

        none, no_mass = [""] * len(limbs), [0.0] * len(limbs)
        bodies = [[f"B{i}", *segments, "platform"] for i, segments in enumerate(names)]
        return Rods(chains, none, no_mass, f"<equality>{joints}</equality>", bodies, amend)

    def _moments(self, limb: Limb) -> list[float]:
        h, d = limb.length / self.elements, limb.rod.diameter
        across = h**2 / 12 + (d**2 / 16 if self.beam == "rayleigh" else 0.0)
        return [limb.line_density * h * square for square in (d**2 / 8, across, across)]


def _chain(i: int, limb: Limb, elements: int) -> str:
    """Return the segments in MJCF, each within the one before, their frames at their middles."""
    rod, h = limb.rod, limb.length / elements
    bend = rod.material.young * rod.second_moment / h
    twist = rod.material.shear * rod.polar_moment / h
    stretch = rod.material.young * rod.area / h
    mass = limb.line_density * h
    still = STILL * limb.line_density * limb.length
    chain = (
        f'<body pos="{text(h / 2, 0, 0)}">{_spring("slide", "1 0 0", 2 * stretch)}'
        f'{inertial(still, still * h**2)}<site name="T{i}"/></body>'
    )
    for k in reversed(range(elements)):
        end = 2 if k == 0 else 1
        springs = [
            _spring("slide", "1 0 0", end * stretch),
            _spring("hinge", "1 0 0", end * twist, -h / 2),
            _spring("hinge", "0 0 1", end * bend, -h / 2),
        ]
        if k:
            springs.append(_spring("hinge", "0 1 0", bend, -h / 2))
        chain = (
            f'<body name="S{i}_{k}" pos="{text(h if k else h / 2, 0, 0)}">'
            f"{''.join(springs)}{inertial(mass, mass * h**2)}{chain}</body>"
        )
    return chain


def _spring(kind: str, axis: str, stiffness: float, at: float = 0.0) -> str:
    return (
        f'<joint type="{kind}" axis="{axis}" stiffness="{text(stiffness)}" pos="{text(at, 0, 0)}"/>'
    )


def _stiffness(model: Any, _data: Any, _limbs: list[Limb]) -> NDArray[np.float64]:
    """Return K, which is diagonal: every spring has a coordinate of its own."""
    springs = np.zeros(model.nv)
    springs[model.jnt_dofadr] = model.jnt_stiffness
    return np.diag(springs)
