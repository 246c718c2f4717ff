"""Checks of height, limbs and the regular workspace."""

import numpy as np

from harness.studies.claims.data import CANNOT, FAILS, HOLDS, ONLY_IF, Claim, Finding, Rules, reads
from harness.studies.claims.facts import CASES, Facts


@reads("beams")
def three_prs(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Do the limbs between R and S keep their length?"""
    spans = [facts.beams.lengths[case] for case in CASES]
    shortest, longest = min(low for low, _ in spans), max(high for _, high in spans)
    measured = f"L_i from {shortest:.4f} to {longest:.4f} m at both cases' poses"
    if longest - shortest <= rules.exact:
        return Finding(measured, "none", HOLDS)
    verdict = f"{FAILS}: L_i changes by {longest - shortest:.4f} m, so P is between R and S: 3-RPS"
    return Finding(measured, "none", verdict)


@reads("beams")
def height(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Are the limbs within their printed limits at the printed height?"""
    beams = facts.beams
    shortest, longest = claim.args["shortest"], claim.args["longest"]
    inside, words = {}, []
    for suffix in ("-as-printed", ""):
        spans = [beams.lengths[case + suffix] for case in CASES]
        low, high = min(low for low, _ in spans), max(high for _, high in spans)
        z = beams.heights[CASES[0] + suffix]
        inside[z] = shortest <= low and high <= longest
        words.append(f"L_i from {low:.3f} to {high:.3f} m at z = {z:g} m")
    measured = "; ".join(words)
    printed, read = inside
    if inside[printed]:
        return Finding(measured, "none", HOLDS)
    if inside[read]:
        return Finding(measured, "none", f"{ONLY_IF} z = {printed:g} m is read as {read:g} m")
    return Finding(measured, "none", f"{FAILS}: neither height is within reach")


@reads("maps")
def angle_limits(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Does the regular workspace follow from what is printed, without the joints' limits?"""
    volumes = {angle: cone for angle, (cone, _) in facts.maps.volumes.items()}
    measured = "; ".join(f"{v:.4f} rad^2 m at {angle:g} deg" for angle, v in volumes.items())
    apart = 100 * (max(volumes.values()) / min(volumes.values()) - 1)
    if apart <= rules.agrees_percent:
        return Finding(measured, "none", HOLDS)
    verdict = f"{CANNOT}: neither angle is given, and the volume changes by up to {apart:.0f} %"
    return Finding(measured, "none", verdict)


@reads("maps")
def cone(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Do the largest inscribed circles make up a truncated cone?"""
    found = facts.maps
    inner, whole = found.volumes[found.limit]
    share = 100 * inner / whole
    measured = f"the largest cone holds {share:.1f} % of the circles' volume"
    own = f"none; joints limited to {found.limit:g} deg, which is not printed"
    if 100 - share <= rules.agrees_percent:
        return Finding(measured, own, HOLDS)
    verdict = f"{ONLY_IF} the cone is the largest inside the circles, not made up of them"
    return Finding(measured, own, verdict)


@reads("maps")
def symmetry(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Are the frequencies the same all round a circle of one tilt and height?"""
    found = facts.maps
    words = ", ".join(f"f{i} varies by {100 * v:.2f} %" for i, v in enumerate(found.ripple, 1))
    measured = f"by {found.model}, round a circle {words}; a turn of {found.period:g} deg changes "
    measured += f"them by {found.turned:.0e}"
    own = f"{rules.exact:.0e} (rounding)"
    if 100 * found.ripple.max() <= rules.agrees_percent:
        return Finding(measured, own, HOLDS)
    if found.turned <= rules.exact:
        verdict = f"{ONLY_IF} it means periodic by {found.period:g} degrees, as the limbs are"
        return Finding(measured, own, verdict)
    return Finding(measured, own, f"{FAILS}: even a turn from limb to limb changes them")


@reads("maps")
def falls(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Do the frequencies fall from layer to layer?"""
    found = facts.maps
    low, high = 1000 * found.z[[0, -1]]
    measured = (
        f"by {found.model}, f1-f3 fall in {found.steps - found.rising} of {found.steps} steps "
    )
    measured += f"from z = {low:.0f} to {high:.0f} mm"
    own = f"steps of {1000 * np.diff(found.z).max():.1f} mm"
    if not found.rising:
        return Finding(measured, own, HOLDS)
    if found.rising == found.steps:
        return Finding(measured, own, f"{FAILS}: they rise")
    verdict = f"{ONLY_IF} {found.rising} of {found.steps} steps are left out, where they rise"
    return Finding(measured, own, verdict)


@reads("maps")
def lowest_best(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Is f1 of the level platform highest where it is lowest?"""
    found = facts.maps
    k = int(np.nanargmax(found.level))
    ends = found.level[[0, -1]]
    measured = f"f1 of the level platform is {ends[0]:.1f} Hz at z = {1000 * found.z[0]:.0f} mm, "
    measured += f"{ends[1]:.1f} Hz at {1000 * found.z[-1]:.0f} mm"
    own = f"steps of {1000 * np.diff(found.z).max():.1f} mm"
    if k == 0:
        return Finding(measured, own, HOLDS)
    if k == len(found.z) - 1:
        return Finding(measured, own, f"{FAILS}: f1 is highest at the greatest height")
    verdict = f"{ONLY_IF} it stays above z = {1000 * found.z[k]:.0f} mm, where f1 is highest"
    return Finding(measured, own, verdict)
