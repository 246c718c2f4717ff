"""MuJoCo 3: the rod as `<composite type="cable">`, rigid cylinders on sprung ball joints.

Inextensible; the cylinders' own inertia is that of the rod's sections. `initial="none"` fixes the
first cylinder to the hinge body, so that the rod bends one element too late: first order.
"""

from typing import Any

from reference_models.mujoco.rig import Limb, Rods, text

THEORY = "inextensible Rayleigh"
LIMIT = ""
ORDER = 1
TORSION = True
REFINEMENTS = (16, 32)  # first order: eight segments are far from the limit
REMARK = "this cable is inextensible and converges with the first order of the elements only"


def rods(limbs: list[Limb], elements: int) -> Rods:
    """Return the rods, each closed by a `connect` (a point on a point) at A_i."""
    inside = [
        f'<composite prefix="R{i}_" type="cable" curve="s 0 0" count="{elements + 1} 1 1" '
        f'size="{text(limb.length)}" initial="none"><plugin plugin="mujoco.elasticity.cable">'
        f'<config key="bend" value="{text(limb.rod.material.young)}"/>'
        f'<config key="twist" value="{text(limb.rod.material.shear)}"/></plugin>'
        f'<geom type="cylinder" size="{text(limb.rod.diameter / 2)}" '
        f'density="{text(limb.rod.material.density)}"/></composite>'
        for i, limb in enumerate(limbs)
    ]
    joints = "".join(f'<connect site1="R{i}_S_last" site2="A{i}"/>' for i in range(len(limbs)))
    rest = (
        f"<equality>{joints}</equality>"
        '<extension><plugin plugin="mujoco.elasticity.cable"/></extension>'
    )
    inner = [*(f"B_{k}" for k in range(1, elements - 1)), "B_last"]
    bodies = [[f"B{i}", *(f"R{i}_{name}" for name in inner), "platform"] for i in range(len(limbs))]
    none = [""] * len(limbs)

    def exact(model: Any) -> None:
        # The composite keeps its points in single precision: cylinders are 3e-7 of them too long.
        for i, limb in enumerate(limbs):
            h, r = limb.length / elements, limb.rod.diameter / 2
            end, mass = (h, 0.0, 0.0), limb.line_density * h
            across = mass * (3 * r**2 + h**2) / 12
            for name in (f"R{i}_B_first", *bodies[i][1:-1]):
                body = model.body(name)
                if name != f"R{i}_B_first":
                    body.pos = end
                body.mass, body.inertia = mass, (across, across, mass * r**2 / 2)
                body.ipos = (h / 2, 0.0, 0.0)
                (cylinder,) = range(body.geomadr[0], body.geomadr[0] + body.geomnum[0])
                model.geom(cylinder).size = (r, h / 2, 0.0)
                model.geom(cylinder).pos = body.ipos
            model.site(f"R{i}_S_last").pos = end

    return Rods(inside, none, [0.0] * len(limbs), rest, bodies, exact)
