"""`mujoco-chain`: limbs as chains of rigid segments, sprung against each other, in MuJoCo.

Plain bodies, joints and springs, the same in every MuJoCo version. The springs between two of n
segments of length h = L / n of a rod stand for the rod between their middles: EA / h to stretch,
E Ix / h and E Iy / h to bend, G J / h to twist. Those at the rod's ends stand for half of that and
are twice as stiff, in series with the joint there (see `segments`): where the joint is free, no
moment and no force reaches the segment.
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
from reference_models.chain_placement import largest_gap, stand
from reference_models.mujoco import system
from reference_models.mujoco.rig import HEAD, platform_body, surplus, text
from reference_models.mujoco.segments import Segmented, closures, segmented, written
from reference_models.mujoco.system import Assembly

Array = NDArray[np.float64]

NAME = "mujoco-chain"
SHEARLESS = {"euler-bernoulli": "Euler-Bernoulli", "rayleigh": "Rayleigh"}


@dataclass(frozen=True)
class MujocoChain:
    """Limbs of any chain, `elements` rigid segments a rod, closed at A_i by exact projection.

    `beam` says what inertia a segment has about its diameters: "euler-bernoulli" that of a line,
    m h^2 / 12, or "rayleigh" that of the rod it is, m h^2 / 12 + rho I h. About its axis it has
    rho (Ix + Iy) h. Raises `InputError` for fewer than two elements or another `beam`.
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
        """Return the `count` lowest modes at one pose; raises as `system.run`.

        Limbs of any chain are taken; motions of a limb's own that need no energy are left out.
        """
        theory = SHEARLESS[self.beam]
        return system.run(
            NAME, theory, self.elements, self._assembly, mechanism, pose, count, chains=True
        )

    def _assembly(self, mechanism: Mechanism, pose: Pose) -> Assembly:
        o, R, standing = stand(mechanism, pose)
        rotary = self.beam == "rayleigh"
        limbs = [segmented(limb, R, self.elements, rotary=rotary) for limb in standing]
        sites = "".join(_held(limb, R) for limb in limbs)
        bodies = platform_body(mechanism, o, R, sites) + "".join(map(written, limbs))
        document = (
            f"{HEAD}<worldbody>{bodies}</worldbody><equality>{closures(limbs)}</equality></mujoco>"
        )

        def amend(model: Any) -> None:
            model.body("platform").inertia -= surplus(mechanism)
            for mass in (mass for limb in limbs for mass in limb.masses):
                model.body(mass.name).inertia -= np.trace(mass.inertia)

        def gap(model: Any, data: Any) -> float:
            tips = np.array([data.site(f"A{limb.limb.number}").xpos for limb in limbs])
            beside = largest_gap(standing, R, tips)
            apart = [np.reshape(data.efc_pos, (-1, 3))]
            for mass in (mass for limb in limbs for mass in limb.masses):
                first, number = model.body(mass.name).jntadr[0], model.body(mass.name).jntnum[0]
                apart.append(data.xanchor[first : first + number] - mass.gap.point)
            return max(beside, float(np.linalg.norm(np.concatenate(apart), axis=1).max()))

        def lines(model: Any, data: Any) -> Array:
            from reference_models.mujoco import geometry

            return np.stack([geometry.chain_line(model, data, limb) for limb in limbs])

        spins = None if mechanism.simple else sum(limb.may_spin for limb in standing)
        return Assembly(document, amend, gap, lines, stiffness, spins)


def _held(limb: Segmented, R: Array) -> str:
    """Return the platform's site at A_i, in the limb's axes."""
    axes, of = R.T @ limb.limb.frame, limb.limb
    place, turned = text(np.array(of.limb.platform_point)), text(axes[:, 0], axes[:, 1])
    return f'<site name="A{of.number}" pos="{place}" xyaxes="{turned}"/>'


def stiffness(model: Any, _data: Any) -> Array:
    """Return K, which is diagonal: every spring has a coordinate of its own."""
    springs = np.zeros(model.nv)
    springs[model.jnt_dofadr] = model.jnt_stiffness
    return np.diag(springs)
