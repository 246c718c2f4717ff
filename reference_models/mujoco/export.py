"""The MJCF of `mujoco-cable` and a script that reads its frequencies, for anybody's MuJoCo 4."""

from xml.etree import ElementTree

from analytic.errors import InputError
from analytic.mechanism import Mechanism
from analytic.modes import check_count
from analytic.pose import Pose, one_pose
from reference_models.catalogue import Named
from reference_models.export import Export, about
from reference_models.mujoco import flex
from reference_models.mujoco.cable import NAME, MujocoCable
from reference_models.mujoco.linearise import STEP
from reference_models.mujoco.rig import document, limbs_of, surplus

SCRIPT = '''"""Natural frequencies [Hz] of rps.xml by MuJoCo 4 and numpy alone: `python rps.py`.

MuJoCo's own linearisation (mjd_transitionFD) softens joints; this one takes the mass matrix and the
passive forces that MuJoCo computes, and differences of the latter.
"""

import sys
from pathlib import Path

import mujoco
import numpy as np

COUNT, STEP = {count}, {step!r}  # modes; displacement of the differences [m or rad]
model = mujoco.MjModel.from_xml_path(str(Path(__file__).with_name("rps.xml")))
# The compiler refuses a flat plate where, by rounding, a moment exceeds the sum of the others:
# rps.xml has the same added to all three. Put right here:
model.body("platform").inertia -= {surplus!r}
data = mujoco.MjData(model)
mujoco.mj_setConst(model, data)
mujoco.mj_resetData(model, data)
mujoco.mj_fwdPosition(model, data)
M = np.zeros((model.nv, model.nv))
mujoco.mj_fullM(model, data, M)


def force(q):
    """Return the passive forces where coordinates are displaced by q."""
    data.qpos[:] = model.qpos0
    mujoco.mj_integratePos(model, data.qpos, q, 1.0)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_flex(model, data)
    mujoco.mj_passive(model, data)
    return np.array(data.qfrc_passive)


def column(e):
    """Return a column of the stiffness, by differences of fourth order."""
    near, far = (force(h * e) - force(-h * e) for h in (STEP, 2 * STEP))
    return -(8 * near - far) / (12 * STEP)


K = np.array([column(e) for e in np.eye(model.nv)])
L = np.linalg.inv(np.linalg.cholesky(M))
omega2 = np.linalg.eigvalsh(L @ (K + K.T) / 2 @ L.T)[:COUNT]
np.savetxt(sys.stdout, np.sqrt(omega2) / (2 * np.pi), fmt="%.6f")
'''


def export(mechanism: Mechanism, pose: Pose, elements: int | None = None, count: int = 6) -> Export:
    """Return `rps.xml` and `rps.py`; raises `InputError` for what the model refuses."""
    model = MujocoCable() if elements is None else MujocoCable(elements)
    check_count(count, 6 + len(mechanism.limbs) * (3 * model.elements - 2))
    limbs = limbs_of(mechanism, one_pose(mechanism, pose))
    named = Named(NAME, model.elements)
    if "--" in (top := "\n".join(about(mechanism, pose, named))):
        raise InputError("pose", pose, "one whose numbers may stand in an XML comment")
    root = ElementTree.fromstring(
        document(mechanism, pose, limbs, flex.rods(limbs, model.elements))
    )
    ElementTree.indent(root)
    _comment(root)
    text = f"<!--\n{top}\n-->\n{ElementTree.tostring(root, encoding='unicode')}\n"
    step = STEP * min(limb.length for limb in limbs)
    script = SCRIPT.format(count=count, step=step, surplus=surplus(mechanism))
    return Export({"rps.xml": text, "rps.py": script}, "python rps.py", named)


def _comment(root: ElementTree.Element) -> None:
    """Put a comment before the first body of each kind."""
    words = {
        "platform": "The rigid platform, its frame at o; at A_i the last of the rods' masses",
        "B0": "Limb by limb: a hinge about the revolute axis at B_i, then the rod's point masses",
        "rod0": "The rods: discrete elastic rods through hinge body, point masses and platform",
    }
    for parent in list(root.iter()):
        for child in list(parent):
            said = words.get(child.get("name", ""))
            if said:
                note = ElementTree.Comment(f" {said}. ")
                note.tail = "\n    "
                parent.insert(list(parent).index(child), note)
