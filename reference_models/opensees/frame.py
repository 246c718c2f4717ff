"""A frame in OpenSees, timed: a program by itself, which needs openseespy, numpy and scipy.

It reads a problem in JSON (see `peer`) and writes frequencies and seconds by round. All is in the
platform's own axes, in which its inertia is diagonal, as OpenSees takes it. Joints are stiff
springs in the joints' directions: OpenSeesPy constrains no directions but those of its axes.
"""

import json
import sys
import time
from typing import Any

import numpy as np
import scipy.linalg

STIFF = 1e7
"""A joint's springs in times of the rod's own stiffness: softens a frequency by about 2e-7."""


def build(ops: Any, problem: dict[str, Any]) -> None:
    """Make the model: `elements` a rod, consistent masses, joints and a rigid platform."""
    s = problem["elements"]
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    platform, tag, element = 1, 2, 1
    ops.node(platform, 0.0, 0.0, 0.0)
    ops.mass(platform, *([problem["mass"]] * 3), *problem["inertia"])
    for i, limb in enumerate(problem["limbs"]):
        base, tip = np.array(limb["base"]), np.array(limb["tip"])
        x, y = limb["x"], limb["y"]
        A, E, G, polar, second, rho = (limb[k] for k in ("A", "E", "G", "polar", "second", "rho"))
        length = float(np.linalg.norm(tip - base))
        ground, first, last, arm = tag, tag + 1, tag + 1 + s, tag + 2 + s
        tag += s + 3
        ops.node(ground, *base)
        for k in range(s + 1):
            ops.node(first + k, *(base + (tip - base) * k / s))
        ops.node(arm, *tip)
        ops.fix(ground, 1, 1, 1, 1, 1, 1)
        ops.geomTransf("Linear", i + 1, *x)
        for k in range(s):
            ends = first + k, first + k + 1
            ops.element("elasticBeamColumn", element, *ends, A, E, G, polar, second, second, i + 1,
                        "-mass", rho * A, "-cMass")  # fmt: skip
            element += 1
        stretch, turn = 2 * i + 1, 2 * i + 2
        ops.uniaxialMaterial("Elastic", stretch, STIFF * E * A / length)
        ops.uniaxialMaterial("Elastic", turn, STIFF * E * second / length)
        # Local axes: the revolute axis, then across it; the rotation about the first is free.
        ops.element("zeroLength", element, ground, first, "-mat", *([stretch] * 3), turn, turn,
                    "-dir", 1, 2, 3, 5, 6, "-orient", *y, *x)  # fmt: skip
        ops.element("zeroLength", element + 1, last, arm, "-mat", *([stretch] * 3),
                    "-dir", 1, 2, 3)  # fmt: skip
        element += 2
        ops.rigidLink("beam", platform, arm)
    ops.constraints("Transformation")
    ops.numberer("RCM")


def main() -> None:
    """Answer the problem on standard input."""
    import openseespy.opensees as ops

    problem = json.load(sys.stdin)
    K, M = (np.array(problem[name]) for name in ("K", "M"))
    found: dict[str, Any] = {"version": str(ops.version()), "build": [], "solve": [], "eigh": []}
    for _ in range(problem["rounds"] + 1):
        clock = [time.perf_counter()]
        build(ops, problem)
        clock.append(time.perf_counter())
        eigenvalues = ops.eigen(problem["solver"], problem["count"])
        clock.append(time.perf_counter())
        scipy.linalg.eigh(K, M)
        clock.append(time.perf_counter())
        for name, seconds in zip(("build", "solve", "eigh"), np.diff(clock), strict=True):
            found[name].append(float(seconds))
    found["frequencies"] = (np.sqrt(np.sort(eigenvalues)) / (2 * np.pi)).tolist()
    print(json.dumps(found))


if __name__ == "__main__":
    main()
