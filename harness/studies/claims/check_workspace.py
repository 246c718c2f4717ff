"""Checks of height, limbs and the regular workspace."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from harness.cases import PRESETS
from harness.studies.claims.data import (
    CANNOT,
    FAILS,
    ONLY_IF,
    ROUNDED,
    RULES,
    Finding,
    finding,
    reads,
)
from harness.studies.claims.facts import CASES, PAPER, Beams, Facts, Maps


def _span(beams: Beams, suffix: str = "") -> tuple[float, float]:
    """Return the shortest and the longest limb over both cases [m]."""
    low, high = zip(*(beams.lengths[case + suffix] for case in CASES), strict=True)
    return min(low), max(high)


@reads("beams")
def three_prs(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Do the limbs between R and S keep their length?"""
    low, high = _span(facts.beams)
    measured = f"L_i from {low:.4f} to {high:.4f} m at both cases' poses"
    otherwise = f"{FAILS}: L_i changes by {high - low:.4f} m, so P is between R and S: 3-RPS"
    return finding(high - low <= RULES.exact, measured, "none", otherwise)


@reads("beams")
def height(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Are the limbs within their printed limits at the printed height?"""
    inside, words = {}, []
    for suffix in ("-as-printed", ""):
        low, high = _span(facts.beams, suffix)
        z = PRESETS[CASES[0] + suffix].pose.z
        inside[z] = args["shortest"] <= low and high <= args["longest"]
        words.append(f"L_i from {low:.3f} to {high:.3f} m at z = {z:g} m")
    printed, read = inside
    otherwise = f"{FAILS}: neither height is within reach"
    if inside[read]:
        otherwise = f"{ONLY_IF} z = {printed:g} m is read as {read:g} m"
    return finding(inside[printed], "; ".join(words), "none", otherwise)


@reads("maps")
def angle_limits(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Does the regular workspace follow from what is printed, without the joints' limits?"""
    volumes = {angle: cone for angle, (cone, _) in facts.maps.volumes.items()}
    measured = "; ".join(f"{v:.4f} rad^2 m at {angle:g} deg" for angle, v in volumes.items())
    apart = 100 * (max(volumes.values()) / min(volumes.values()) - 1)
    otherwise = f"{CANNOT}: neither angle is given, and the volume changes by up to {apart:.0f} %"
    return finding(apart <= RULES.agrees_percent, measured, "none", otherwise)


@reads("maps")
def cone(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Do the largest inscribed circles make up a truncated cone?"""
    limit = facts.maps.limit
    inner, whole = facts.maps.volumes[limit]
    share = 100 * inner / whole
    measured = f"the largest cone holds {share:.1f} % of the circles' volume"
    own = f"none; joints limited to {limit:g} deg, which is not printed"
    otherwise = f"{ONLY_IF} the cone is the largest inside the circles, not made up of them"
    return finding(100 - share <= RULES.agrees_percent, measured, own, otherwise)


@reads("maps")
def symmetry(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Are the frequencies the same all round a circle of one tilt and height?"""
    found = facts.maps
    words = ", ".join(f"f{i} varies by {100 * v:.2f} %" for i, v in enumerate(found.ripple, 1))
    measured = (
        f"by {PAPER.label}, round a circle {words}; a turn of {found.period:g} deg changes them "
        f"by {found.turned:.0e}"
    )
    otherwise = f"{FAILS}: even a turn from limb to limb changes them"
    if found.turned <= RULES.exact:
        otherwise = f"{ONLY_IF} it means periodic by {found.period:g} degrees, as the limbs are"
    same = 100 * found.ripple.max() <= RULES.agrees_percent
    return finding(bool(same), measured, ROUNDED, otherwise)


@reads("maps")
def falls(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Do the frequencies fall from layer to layer?"""
    found = facts.maps
    low, high = 1000 * found.z[[0, -1]]
    measured = (
        f"by {PAPER.label}, f1-f3 fall in {found.steps - found.rising} of {found.steps} steps "
        f"from z = {low:.0f} to {high:.0f} mm"
    )
    otherwise = f"{ONLY_IF} {found.rising} of {found.steps} steps are left out, where they rise"
    if found.rising == found.steps:
        otherwise = f"{FAILS}: they rise"
    return finding(not found.rising, measured, _layers(found), otherwise)


@reads("maps")
def lowest_best(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Is f1 of the level platform highest where it is lowest?"""
    found = facts.maps
    k, z, ends = int(np.nanargmax(found.level)), 1000 * found.z, found.level[[0, -1]]
    measured = (
        f"f1 of the level platform is {ends[0]:.1f} Hz at z = {z[0]:.0f} mm, {ends[1]:.1f} Hz at "
        f"{z[-1]:.0f} mm"
    )
    otherwise = f"{ONLY_IF} it stays above z = {z[k]:.0f} mm, where f1 is highest"
    if k == len(z) - 1:
        otherwise = f"{FAILS}: f1 is highest at the greatest height"
    return finding(k == 0, measured, _layers(found), otherwise)


def _layers(found: Maps) -> str:
    return f"steps of {1000 * np.diff(found.z).max():.1f} mm"
