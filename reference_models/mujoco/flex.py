"""MuJoCo 4: the rod as a one-dimensional flex, a discrete elastic rod with lumped masses.

Vertices carry the mass and only translate. Every inner vertex bends with EI / l (twice that where
the clamp makes half its span rigid); edges stretch with EA / l. No shear, no rotary inertia and,
as the spherical joint leaves it unloaded, no torsion.
"""

import numpy as np

from reference_models.mujoco.rig import Limb, Rods, inertial, text

THEORY = "Euler-Bernoulli"
LIMIT = "euler-bernoulli"
ORDER = 2
TORSION = False
REFINEMENTS = (8, 16)
REMARK = "discrete elastic rod with lumped masses; the limbs' torsion modes are absent"

CLAMP = 0.01
"""Length of the edge on the hinge body, relative to the others. It lies half before and half
behind B_i, so that the first vertex to bend stands for the half span beyond it and no more: all
of it behind would leave an error of the first order."""


def rods(limbs: list[Limb], elements: int) -> Rods:
    """Return the rods: vertices on the hinge body, on bodies of their own, and on the platform.

    The last vertex is a point of the platform: an ideal spherical joint, with nothing to close.
    """
    beside, flexes, bodies, tip_mass = [], [], [], []
    for i, limb in enumerate(limbs):
        half = CLAMP * limb.length / elements / 2
        edge = (limb.length - half) / elements
        names = [f"V{i}_{k}" for k in range(1, elements)]
        beside.append(
            "".join(
                f'<body name="{name}" pos="{text(limb.base + (half + k * edge) * limb.along)}">'
                '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>'
                '<joint type="slide" axis="0 0 1"/>'
                f"{inertial(limb.line_density * edge, 1.0)}</body>"
                for k, name in enumerate(names, start=1)
            )
        )
        vertices = np.zeros((elements + 2, 3))
        vertices[:2, 0] = -half, half
        vertices[-1] = limb.point
        # All of the limb stretches, the half edge on the hinge body too.
        stretch = limb.rod.material.young * limb.rod.area * elements / limb.length
        flexes.append(
            f'<flex name="rod{i}" dim="1" radius="{text(limb.rod.diameter / 2)}" '
            f'body="{" ".join([f"B{i}", f"B{i}", *names, "platform"])}" vertex="{text(vertices)}" '
            f'element="{" ".join(f"{k} {k + 1}" for k in range(elements + 1))}">'
            f'<edge stiffness="{text(stretch)}"/>'
            f'<elasticity young="{text(limb.rod.material.young)}"/></flex>'
        )
        bodies.append([f"B{i}", *names, "platform"])
        tip_mass.append(limb.line_density * edge / 2)
    rest = f"<deformable>{''.join(flexes)}</deformable>"
    return Rods([""] * len(limbs), beside, tip_mass, rest, bodies)
