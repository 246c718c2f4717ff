"""`exudyn-ffrf`: solid rods in Exudyn's floating frame of reference."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from analytic.errors import InputError
from analytic.errors import count as whole
from analytic.mechanism import Mechanism, Rod
from analytic.model import Info
from analytic.modes import Modes
from analytic.pose import Pose
from reference_models.exudyn.system import Axis, Line, describe, run
from reference_models.protocol import ModelError, UnavailableError
from reference_models.solid.faces import FACES
from reference_models.solid.ngsolve import RIM_ORDER
from reference_models.solid.ngsolve_mesh import load as load_ngsolve
from reference_models.solid.nodal_rod import nodal_rod
from reference_models.solid.rod import SLENDERNESS
from reference_models.spent import SIMULATOR, phase

NAME = "exudyn-ffrf"
THEORY = f"3-D elasticity, {FACES['rigid']}"
FINEST, MOST_MODES = 6, 100

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ExudynFfrf:
    """Limbs as ObjectFFRFreducedOrder: the rods of `ngsolve-solid`, reduced by Exudyn.

    NGSolve meshes a rod with `elements` as there, order 2. Exudyn reduces it to the rigid motion
    of both end faces (RBE2) and the `modes_kept` lowest modes between fixed faces (Hurty, Craig
    and Bampton), and does all else: joints, platform, linearisation.
    Raises `InputError` for fewer than one element or mode, more than 6 elements or 100 modes.
    """

    elements: int = 4
    modes_kept: int = 12

    def __post_init__(self) -> None:
        if whole("elements", self.elements) > FINEST:
            expected = f"at most {FINEST}: the reduction of finer rods takes minutes and gigabytes"
            raise InputError("elements", self.elements, expected)
        if whole("modes_kept", self.modes_kept) > MOST_MODES:
            raise InputError("modes_kept", self.modes_kept, f"at most {MOST_MODES}")

    @classmethod
    def info(cls) -> Info:
        """Return what the model is; never raises."""
        remark = (
            "the rods of ngsolve-solid, order 2, rigid faces: they converge as those do; Exudyn "
            "reduces every new length anew, in seconds"
        )
        known = describe(
            THEORY, RIM_ORDER, (2, 4), remark, ladder=(1, 2), relaxed="ngsolve-averaged",
            assumption="rigid end faces", slow=True,
        )  # fmt: skip
        try:
            load_ngsolve()
        except UnavailableError as error:
            return replace(known, missing="; ".join(filter(None, [known.missing, str(error)])))
        return known

    @property
    def theory(self) -> str:
        """The theory, how the joints hold the end faces, and what the rods are reduced to."""
        return f"{THEORY}, {self.modes_kept} modes"

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose; raises as `exudyn_system.run`.

        Raises `UnavailableError` without NGSolve and `ModelError` where it or Netgen fails.
        """
        mesher = load_ngsolve().__version__
        modes = run(NAME, self.theory, self.elements, self._add_rod, mechanism, pose, count)
        return replace(modes, version=f"{modes.version}, ngsolve {mesher}")

    def _add_rod(self, exu: Any, mbs: Any, axis: Axis) -> Line:
        items, material = exu.itemInterface, axis.rod.material
        # Rounded, so that lengths equal but for rounding share a reduction; the gap shows by how
        # much.
        length = float(f"{axis.length:.13g}")
        with phase(SIMULATOR):
            reduced = _reduced(axis.rod, length, self.elements, self.modes_kept)
        rod = nodal_rod(material.poisson, self.elements)
        along, about, across = axis.frame.T
        frame = np.stack([-across, about, along], axis=1)
        made = reduced.AddObjectFFRFreducedOrder(
            mbs, positionRef=axis.base, rotationMatrixRef=frame
        )
        body, node = made["oFFRFreducedOrder"], made["nRigidBody"]
        # Modes are relative to the base face, so that the body's own node moves with it.
        ground = mbs.AddObject(
            items.ObjectGround(referencePosition=axis.base, referenceRotation=frame)
        )
        fixed = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=ground))
        first = mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=node))
        mbs.AddObject(
            items.GenericJoint(markerNumbers=[fixed, first], constrainedAxes=[1, 1, 1, 1, 0, 1])
        )
        # The face is rigid and its nodes lie evenly round its middle.
        last = mbs.AddMarker(
            items.MarkerSuperElementPosition(
                bodyNumber=body,
                meshNodeNumbers=rod.tip,
                weightingFactors=np.full(len(rod.tip), 1 / len(rod.tip)),
            )
        )
        velocity = exu.OutputVariableType.Velocity
        near = np.flatnonzero(rod.axis.any(axis=0))

        def velocities() -> Array:
            moving = [mbs.GetObjectOutputSuperElement(body, velocity, int(n)) for n in near]
            return np.asarray(rod.axis[:, near] @ np.array(moving))

        return Line(velocities, (fixed, first), last)


@lru_cache(maxsize=8)
def _reduced(rod: Rod, length: float, elements: int, modes_kept: int) -> Any:
    """Return Exudyn's reduction of a rod; equal rods of equal length share it."""
    from exudyn.FEM import FEMinterface, HCBstaticModeSelection, ObjectFFRFreducedOrderInterface

    nodal, d = nodal_rod(rod.material.poisson, elements), rod.diameter
    positions, K, M = nodal.stretched(length / (d * SLENDERNESS))
    fem = FEMinterface()
    fem.nodes = {"Position": d * positions}
    fem.stiffnessMatrix = sp.csr_matrix(rod.material.young * d * K)
    fem.massMatrix = sp.csr_matrix(rod.material.density * d**3 * M)
    try:
        fem.ComputeHurtyCraigBamptonModes(
            [nodal.base.tolist(), nodal.tip.tolist()],
            modes_kept,
            computationMode=HCBstaticModeSelection.RBE2,
        )
    except RuntimeError as error:  # of its eigensolver
        raise ModelError(f"{NAME}: {error}") from error
    # By default Exudyn drops entries below 1e-13 of the largest: in small rods that is torsion.
    return ObjectFFRFreducedOrderInterface(fem, roundMassMatrix=0, roundStiffnessMatrix=0)
