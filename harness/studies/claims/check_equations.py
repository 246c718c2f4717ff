"""Checks of Eqs. (1)-(22): what each says, against what it must satisfy."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from harness.studies.claims.check_printed import WHOLE
from harness.studies.claims.data import FAILS, ONLY_IF, ROUNDED, RULES, Finding, finding, reads
from harness.studies.claims.equations import PHI, STEP
from harness.studies.claims.facts import PAPER, Facts, Floats

RESIDUALS = {
    "rotation": ("rotation", "R^T R = 1 and det R = 1 to", "R is no rotation"),
    "plane": (
        "beside_plane",
        "every A_i is in its revolute joint's plane to, in m,",
        "the joints cannot close",
    ),
    "lengths": (
        "lengths_apart",
        "L_i agrees with the closed joints' to, in m,",
        "the lengths are others",
    ),
    "eq17_vertical": (
        "axis_rise",
        "the revolute axes are horizontal to",
        "phi_Bz goes with phi_By",
    ),
}
"""By check: what of `Equations` must vanish, what that means, and what is true otherwise."""


def _residual(field: str, what: str, otherwise: str) -> Any:
    def check(facts: Facts, args: Mapping[str, Any]) -> Finding:
        value = getattr(facts.equations, field)
        return finding(
            value <= RULES.exact, f"{what} {value:.1e}", ROUNDED, f"{FAILS}: {otherwise}"
        )

    return check


for _name, _row in RESIDUALS.items():
    reads("equations", name=_name)(_residual(*_row))


@reads("equations")
def mobility(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Has the platform as many freedoms as is said?"""
    found, said = facts.equations.freedoms, args["printed"]
    otherwise = f"{FAILS}: {found}, not {said}"
    return finding(found == said, f"{found} freedoms of the platform", WHOLE, otherwise)


@reads("equations")
def angles(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Are phi and theta angles about the y- and x-axes?"""
    found = facts.equations
    turn, off = np.degrees([found.phi_alone, found.theta_axis])
    measured = (
        f"phi = {np.degrees(PHI):g} deg alone turns the platform by {turn:.2g} deg; theta alone "
        f"turns it about an axis {off:.3g} deg from x"
    )
    holds = found.theta_axis <= RULES.exact and abs(found.phi_alone - PHI) <= RULES.exact
    otherwise = f"{FAILS}: Eq. (1) is tilt and torsion, theta the tilt and phi the way it leans"
    return finding(bool(holds), measured, f"{RULES.exact:.0e} rad", otherwise)


@reads("equations")
def compatibility(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Is Eq. (10) the motion of a point of a rigid body?"""
    found, own = facts.equations.compatibility, STEP**2  # more than a central difference errs by
    measured = f"A_i moves as it says to {found:.1e} of its arm"
    uncertainty = f"{own:.0e} (central difference)"
    return finding(found <= own, measured, uncertainty, f"{FAILS}: A_i moves otherwise")


@reads("equations")
def rod_size(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Does Eq. (6) have a rod's size?"""
    sizes = facts.equations.sizes
    wrong = [s for s, (rod, *_) in sizes.items() if rod != 3 * 2 * (s + 1)]
    measured = (
        f"6 (s + 1) coordinates for {len(sizes) - len(wrong)} of {len(sizes)} numbers of elements"
    )
    return finding(not wrong, measured, WHOLE, f"{FAILS}: not for s = {wrong}")


@reads("equations")
def dimension(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Are there 18 s independent coordinates?"""
    sizes = facts.equations.sizes
    wrong = [s for s, (_, all_, rank, K) in sizes.items() if not 18 * s == all_ - rank == K]
    _, all_, rank, K = sizes[3]
    measured = f"at s = 3: {all_} coordinates less {rank} constraints = {all_ - rank}; K is {K}"
    return finding(not wrong, measured, WHOLE, f"{FAILS}: not for s = {wrong}")


@reads("equations")
def unknowns(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Do multipliers mean more unknowns?"""
    more, (_, all_, _, own) = facts.equations.multipliers, facts.equations.sizes[3]
    measured = f"{own} against {all_} + {more} = {all_ + more}"
    return finding(all_ + more > own, measured, WHOLE, f"{FAILS}: {all_ + more}, not more")


@reads("beams", "equations")
def inertia(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Can a plate of the printed thickness have the inertia of Eq. (8)?"""
    found, hertz = facts.equations, facts.beams.hertz
    jx, jy, jz = found.moments
    excess, most = jx + jy - jz, found.thickness**2 / 2
    lower = 100 * (hertz["case1-printed-inertia", PAPER][2] / hertz["case1", PAPER][2] - 1)
    measured = f"(Jx + Jy - Jz) / m = {excess:.2e} m^2, of a plate at most {most:.2e}"
    otherwise = (
        f"{FAILS}: no plate of {1000 * found.thickness:g} mm has it; against a disc's it changes "
        f"f3 of case1 by {lower:+.1f} %"
    )
    return finding(excess <= most * (1 + RULES.exact), measured, "none", otherwise)


@reads("equations")
def base_angles(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Does it make no difference to call all of Phi_Bi zero?"""
    changes = {case: 100 * change for case, change in facts.equations.base_clamped.items()}
    words = "; ".join(f"{case}: f1 {v[0]:+.1f} %" for case, v in changes.items())
    largest = max(np.abs(v).max() for v in changes.values())
    otherwise = f"{ONLY_IF} the angle about the revolute axis is kept, as Eqs. (15)-(16) do"
    measured = f"with Phi_Bi = 0 instead of a revolute joint, {words}"
    return finding(largest <= RULES.agrees_percent, measured, "none", otherwise)


def _headings(facts: Facts, smallest: Floats) -> str:
    zero = np.degrees(facts.equations.headings[smallest <= RULES.exact])
    return ", ".join(f"{angle:.0f}" for angle in zero)


@reads("equations")
def eq17(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Is Eq. (17) regular?"""
    found = facts.equations.eq17
    measured = (
        f"smallest R_i(2,2) in magnitude {found[0]:.3f} with a limb on the x-axis, "
        f"{found.min():.0e} over all headings of the base"
    )
    otherwise = (
        f"{ONLY_IF} no limb is on the y-axis: singular with the base turned by "
        f"{_headings(facts, found)} deg"
    )
    if found[0] <= RULES.exact:
        otherwise = f"{FAILS}: R_i(2,2) is zero in the paper's own layout"
    return finding(found.min() > RULES.exact, measured, ROUNDED, otherwise)


@reads("equations")
def eq18(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Is Eq. (18) singular in some configurations?"""
    found, motion = facts.equations.eq18, facts.equations.axis_motion
    singular = found.min() <= RULES.exact
    measured = (
        f"smallest R_i(1,2) in magnitude {found[0]:.0e} with a limb on the x-axis; the "
        f"revolute axes turn by {motion:.0e} from pose to pose"
    )
    otherwise = f"{FAILS}: the denominator is nowhere zero"
    if singular:
        otherwise = (
            f"{ONLY_IF} a limb is on the x-axis (base turned by {_headings(facts, found)} deg), "
            "and then in every configuration: R_i(1,2) does not depend on the pose"
        )
    return finding(bool(singular and motion > RULES.exact), measured, ROUNDED, otherwise)


@reads("equations")
def no_multipliers(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Does the model keep all joints closed and agree with the one with multipliers?"""
    found = facts.equations
    measured = (
        f"modes open the joints by {found.joints_open:.0e} of their largest motion; f1-f6 are "
        f"{found.multipliers_apart:.0e} from those with {found.multipliers} multipliers"
    )
    kept = max(found.joints_open, found.multipliers_apart) <= RULES.exact
    return finding(kept, measured, ROUNDED, f"{FAILS}: a constraint is lost")
