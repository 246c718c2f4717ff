"""Checks of Eqs. (1)-(22): what each says, against what it must satisfy."""

import numpy as np

from harness.studies.claims.data import FAILS, HOLDS, ONLY_IF, Claim, Finding, Rules, reads
from harness.studies.claims.equations import STEP
from harness.studies.claims.facts import PAPER, PHI, Equations, Facts, Floats

WHOLE = "none: whole numbers"


def _residual(value: float, what: str, rules: Rules, otherwise: str) -> Finding:
    """Return whether a residual is rounding, or else that it `otherwise`."""
    verdict = HOLDS if value <= rules.exact else f"{FAILS}: {otherwise}"
    return Finding(f"{what} {value:.1e}", f"{rules.exact:.0e} (rounding)", verdict)


@reads("equations")
def mobility(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Has the platform as many freedoms as is said?"""
    found, said = facts.equations.freedoms, claim.args["printed"]
    verdict = HOLDS if found == said else f"{FAILS}: {found}, not {said}"
    return Finding(f"{found} freedoms of the platform", WHOLE, verdict)


@reads("equations")
def rotation(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Is Eq. (1) a rotation?"""
    what, wrong = "R^T R = 1 and det R = 1 to", "R is no rotation"
    return _residual(facts.equations.rotation, what, rules, wrong)


@reads("equations")
def angles(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Are phi and theta angles about the y- and x-axes?"""
    found = facts.equations
    turn, off = np.degrees([found.phi_alone, found.theta_axis])
    measured = (
        f"phi = {np.degrees(PHI):g} deg alone turns the platform by {turn:.2g} deg; theta alone "
        f"turns it about an axis {off:.3g} deg from x"
    )
    if found.theta_axis <= rules.exact and abs(found.phi_alone - PHI) <= rules.exact:
        return Finding(measured, f"{rules.exact:.0e} rad", HOLDS)
    verdict = f"{FAILS}: Eq. (1) is tilt and torsion, theta the tilt and phi the way it leans"
    return Finding(measured, f"{rules.exact:.0e} rad", verdict)


@reads("equations")
def plane(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Does Eq. (2) keep every A_i in its revolute joint's plane?"""
    what = "every A_i is in its revolute joint's plane to, in m,"
    return _residual(facts.equations.beside_plane, what, rules, "the joints cannot close")


@reads("equations")
def lengths(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Does Eq. (3) give the model's limbs?"""
    what = "L_i agrees with the closed joints' to, in m,"
    return _residual(facts.equations.lengths_apart, what, rules, "the lengths are others")


@reads("equations")
def compatibility(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Is Eq. (10) the motion of a point of a rigid body?"""
    found = facts.equations.compatibility
    own = STEP**2  # more than a central difference errs by
    verdict = HOLDS if found <= own else f"{FAILS}: A_i moves otherwise"
    measured = f"A_i moves as it says to {found:.1e} of its arm"
    return Finding(measured, f"{own:.0e} (central difference)", verdict)


@reads("equations")
def rod_size(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Does Eq. (6) have a rod's size?"""
    wrong = [s for s, (rod, *_) in facts.equations.sizes.items() if rod != 3 * 2 * (s + 1)]
    measured = f"6 (s + 1) coordinates for {len(facts.equations.sizes) - len(wrong)} "
    measured += f"of {len(facts.equations.sizes)} numbers of elements"
    return Finding(measured, WHOLE, f"{FAILS}: not for s = {wrong}" if wrong else HOLDS)


@reads("equations")
def dimension(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Are there 18 s independent coordinates?"""
    sizes = facts.equations.sizes
    wrong = [s for s, (_, all_, rank, K) in sizes.items() if not 18 * s == all_ - rank == K]
    s, (_, all_, rank, K) = next((k, v) for k, v in sizes.items() if k == 3)
    measured = f"at s = {s}: {all_} coordinates less {rank} constraints = {all_ - rank}; K is {K}"
    return Finding(measured, WHOLE, f"{FAILS}: not for s = {wrong}" if wrong else HOLDS)


@reads("beams", "equations")
def inertia(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Can a plate of the printed thickness have the inertia of Eq. (8)?"""
    found, beams = facts.equations, facts.beams
    jx, jy, jz = found.moments
    excess, most = jx + jy - jz, found.thickness**2 / 2
    with_it, disc = beams.readings["case1-printed-inertia"][1], beams.hertz["case1", PAPER]
    lower = 100 * (with_it[2] / disc[2] - 1)
    measured = f"(Jx + Jy - Jz) / m = {excess:.2e} m^2, of a plate at most {most:.2e}"
    if excess <= most * (1 + rules.exact):
        return Finding(measured, "none", HOLDS)
    verdict = (
        f"{FAILS}: no plate of {1000 * found.thickness:g} mm has it; against a disc's it changes "
        f"f3 of case1 by {lower:+.1f} %"
    )
    return Finding(measured, "none", verdict)


@reads("equations")
def base_angles(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Does it make no difference to call all of Phi_Bi zero?"""
    changes = {case: 100 * change for case, change in facts.equations.base_clamped.items()}
    words = "; ".join(f"{case}: f1 {v[0]:+.1f} %" for case, v in changes.items())
    measured = f"with Phi_Bi = 0 instead of a revolute joint, {words}"
    if max(np.abs(v).max() for v in changes.values()) <= rules.agrees_percent:
        return Finding(measured, "none", HOLDS)
    verdict = f"{ONLY_IF} the angle about the revolute axis is kept, as Eqs. (15)-(16) do"
    return Finding(measured, "none", verdict)


def _headings(found: Equations, smallest: Floats, rules: Rules) -> str:
    zero = np.degrees(found.headings[smallest <= rules.exact])
    return ", ".join(f"{angle:.0f}" for angle in zero)


@reads("equations")
def eq17(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Is Eq. (17) regular?"""
    found = facts.equations
    measured = f"smallest R_i(2,2) in magnitude {found.eq17[0]:.3f} with a limb on the x-axis, "
    measured += f"{found.eq17.min():.0e} over all headings of the base"
    own = f"{rules.exact:.0e} (rounding)"
    if found.eq17.min() > rules.exact:
        return Finding(measured, own, HOLDS)
    if found.eq17[0] <= rules.exact:
        return Finding(measured, own, f"{FAILS}: R_i(2,2) is zero in the paper's own layout")
    verdict = (
        f"{ONLY_IF} no limb is on the y-axis: singular with the base turned by "
        f"{_headings(found, found.eq17, rules)} deg"
    )
    return Finding(measured, own, verdict)


@reads("equations")
def eq17_vertical(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Has no limb's base a rotation about the vertical?"""
    what = "the revolute axes are horizontal to"
    return _residual(facts.equations.axis_rise, what, rules, "phi_Bz goes with phi_By")


@reads("equations")
def eq18(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Is Eq. (18) singular in some configurations?"""
    found = facts.equations
    measured = (
        f"smallest R_i(1,2) in magnitude {found.eq18[0]:.0e} with a limb on the x-axis; the "
        f"revolute axes turn by {found.axis_motion:.0e} from pose to pose"
    )
    own = f"{rules.exact:.0e} (rounding)"
    if found.eq18.min() > rules.exact:
        return Finding(measured, own, f"{FAILS}: the denominator is nowhere zero")
    if found.axis_motion > rules.exact:
        return Finding(measured, own, HOLDS)
    verdict = (
        f"{ONLY_IF} a limb is on the x-axis (base turned by "
        f"{_headings(found, found.eq18, rules)} deg), and then in every configuration: R_i(1,2) "
        "does not depend on the pose"
    )
    return Finding(measured, own, verdict)


@reads("equations")
def no_multipliers(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Does the model keep all joints closed and agree with the one with multipliers?"""
    found = facts.equations
    measured = (
        f"modes open the joints by {found.joints_open:.0e} of their largest motion; f1-f6 are "
        f"{found.multipliers_apart:.0e} from those with {found.multipliers} multipliers"
    )
    own = f"{rules.exact:.0e} (rounding)"
    wrong = max(found.joints_open, found.multipliers_apart) > rules.exact
    return Finding(measured, own, f"{FAILS}: a constraint is lost" if wrong else HOLDS)


@reads("equations")
def unknowns(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Do multipliers mean more unknowns?"""
    found = facts.equations
    _, all_, _, own = found.sizes[3]
    rival = all_ + found.multipliers
    measured = f"{own} against {all_} + {found.multipliers} = {rival}"
    return Finding(measured, WHOLE, HOLDS if rival > own else f"{FAILS}: {rival}, not more")
