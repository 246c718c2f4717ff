"""The MJCF of `mujoco-cable`, or of `mujoco-chain` for limbs of any chain, and a script that reads
its frequencies, for anybody's MuJoCo 4.
"""

from xml.etree import ElementTree

import numpy as np

from analytic.errors import InputError, RefusedError
from analytic.mechanism import Mechanism
from analytic.modes import check_count
from analytic.pose import Pose, one_pose
from reference_models.catalogue import Named
from reference_models.chain_placement import Standing, stand
from reference_models.export import SOLVE, Export, about, shift_of
from reference_models.mujoco import chain, flex
from reference_models.mujoco.cable import NAME, MujocoCable
from reference_models.mujoco.chain import MujocoChain
from reference_models.mujoco.rig import STEP, document, limbs_of, surplus
from reference_models.mujoco.segments import segmented

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


CHAIN_SCRIPT = '''"""Natural frequencies [Hz] of rps.xml by MuJoCo 4 and numpy: `python rps.py`.

MuJoCo's own linearisation (mjd_transitionFD) softens joints; this one takes the mass matrix and
the joints' Jacobian of MuJoCo. Every spring has a coordinate of its own: K is diagonal.
"""

import sys
from pathlib import Path

import mujoco
import numpy as np

SPINS = {spins}  # limbs that may turn about themselves
model = mujoco.MjModel.from_xml_path(str(Path(__file__).with_name("rps.xml")))
# The compiler refuses thin bodies where, by rounding or as segments, a moment exceeds the sum of
# the others: rps.xml has their sum added to all three. Put right here:
SURPLUS = {surplus}
for name, moment in SURPLUS.items():
    model.body(name).inertia -= moment
data = mujoco.MjData(model)
mujoco.mj_setConst(model, data)
mujoco.mj_resetData(model, data)
mujoco.mj_fwdPosition(model, data)
M = np.zeros((model.nv, model.nv))
mujoco.mj_fullM(model, data, M)
J = np.array(data.efc_J).reshape(-1, model.nv)
springs = np.zeros(model.nv)
springs[model.jnt_dofadr] = model.jnt_stiffness
{solve}

found = lowest(M, np.diag(springs), J, {count}, {shift!r})
np.savetxt(sys.stdout, found, fmt="%.9f")
'''
LEAST = 1e-14
"""Moments of inertia that MuJoCo takes for none [kg m^2]."""


def export(mechanism: Mechanism, pose: Pose, elements: int | None = None, count: int = 6) -> Export:
    """Return `rps.xml` and `rps.py`; raises `InputError` for what the model refuses."""
    one_pose(mechanism, pose)
    return (_cables if mechanism.simple else _chains)(mechanism, pose, elements, count)


def _chains(mechanism: Mechanism, pose: Pose, elements: int | None, count: int) -> Export:
    model = MujocoChain() if elements is None else MujocoChain(elements)
    R, standing = stand(mechanism, pose)[1:]
    made = model._assembly(mechanism, pose)
    limbs = [segmented(limb, R, model.elements, rotary=False) for limb in standing]
    for limb in limbs:
        for mass in limb.masses:
            if np.trace(mass.inertia) < LEAST:
                found = f"limb {limb.limb.number}, {limb.limb.limb.described}"
                expected = (
                    f"links and segments of {LEAST:.0e} kg m2 and more for MuJoCo in SI units"
                )
                raise RefusedError("mechanism", found, expected)
    moments = {"platform": surplus(mechanism)}
    moments |= {mass.name: float(np.trace(mass.inertia)) for limb in limbs for mass in limb.masses}
    script = CHAIN_SCRIPT.format(
        spins=made.spins,
        surplus="{" + "".join(f"\n    {k!r}: {v!r}," for k, v in moments.items()) + "\n}",
        solve=SOLVE,
        count=count,
        shift=shift_of(standing),
    )
    words = {"platform": "The rigid platform, its frame at o; at A_i a site in the limb's axes"}
    for limb in limbs:
        if limb.masses:
            words[limb.masses[0].name] = _said(limb.limb)
    named = Named(chain.NAME, model.elements)
    return _written(mechanism, pose, named, made.document, words, script)


def _said(limb: Standing) -> str:
    return (
        f"Limb {limb.number}, {limb.limb.described}, in its own axes. Before each body a hinge or "
        "slide for all that gives\n    way there: without stiffness what is free, with it drives, "
        f"bearings and half segments. L{limb.number}_k_j is segment j of\n    item k, from 0"
    )


def _cables(mechanism: Mechanism, pose: Pose, elements: int | None, count: int) -> Export:
    model = MujocoCable() if elements is None else MujocoCable(elements)
    check_count(count, 6 + len(mechanism.limbs) * (3 * model.elements - 2))
    limbs = limbs_of(mechanism, pose)
    text = document(mechanism, pose, limbs, flex.rods(limbs, model.elements))
    step = STEP * min(limb.length for limb in limbs)
    script = SCRIPT.format(count=count, step=step, surplus=surplus(mechanism))
    words = {
        "platform": "The rigid platform, its frame at o; at A_i the last of the rods' masses",
        "B0": "Limb by limb: a hinge about the revolute axis at B_i, then the rod's point masses",
        "rod0": "The rods: discrete elastic rods through hinge body, point masses and platform",
    }
    return _written(mechanism, pose, Named(NAME, model.elements), text, words, script)


def _written(
    mechanism: Mechanism, pose: Pose, named: Named, mjcf: str, words: dict[str, str], script: str
) -> Export:
    """Return the files, with `words` as comments before what has their name."""
    if "--" in (top := "\n".join(about(mechanism, pose, named))):
        raise InputError("pose", pose, "one whose numbers may stand in an XML comment")
    root = ElementTree.fromstring(mjcf)
    ElementTree.indent(root)
    for parent in list(root.iter()):
        for child in list(parent):
            said = words.get(child.get("name", ""))
            if said:
                note = ElementTree.Comment(f" {said}. ")
                note.tail = "\n    "
                parent.insert(list(parent).index(child), note)
    text = f"<!--\n{top}\n-->\n{ElementTree.tostring(root, encoding='unicode')}\n"
    return Export({"rps.xml": text, "rps.py": script}, "python rps.py", named)
