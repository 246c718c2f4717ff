"""Checks of height, limbs and the regular workspace."""

from typing import Any

import numpy as np

from harness.cases import PRESETS
from harness.studies.claims.data import CASES, RULES, Args, Outcome, outcome
from harness.studies.claims.facts import Facts


def _span(facts: Facts, suffix: str = "") -> tuple[float, float]:
    """Return the shortest and the longest limb over both cases [m]."""
    low, high = zip(*(facts.lengths[case + suffix] for case in CASES), strict=True)
    return min(low), max(high)


def three_prs(facts: Facts, args: Args) -> Outcome:
    """Do the limbs between R and S keep their length?"""
    low, high = _span(facts)
    return outcome(high - low <= RULES.exact, low=low, high=high, change=high - low)


def height(facts: Facts, args: Args) -> Outcome:
    """Are the limbs within their printed limits at the printed height?"""
    inside, words, z = [], [], []
    for suffix in ("-as-printed", ""):
        low, high = _span(facts, suffix)
        z.append(PRESETS[CASES[0] + suffix].pose.z)
        inside.append(args["shortest"] <= low and high <= args["longest"])
        words.append(f"L_i from {low:.3f} to {high:.3f} m at z = {z[-1]:g} m")
    return outcome(inside[0], "read" if inside[1] else "otherwise", words="; ".join(words), z=z)


def angle_limits(facts: Facts, args: Args) -> Outcome:
    """Does the regular workspace follow from what is printed, without the joints' limits?"""
    volumes = {angle: cone for angle, (cone, _) in facts.maps.volumes.items()}
    apart = 100 * (max(volumes.values()) / min(volumes.values()) - 1)
    words = "; ".join(f"{v:.4f} rad^2 m at {angle:g} deg" for angle, v in volumes.items())
    return outcome(apart <= RULES.agrees_percent, words=words, apart=apart)


def cone(facts: Facts, args: Args) -> Outcome:
    """Do the largest inscribed circles make up a truncated cone?"""
    inner, whole = facts.maps.volumes[facts.maps.limit]
    share = 100 * inner / whole
    return outcome(100 - share <= RULES.agrees_percent, share=share)


def symmetry(facts: Facts, args: Args) -> Outcome:
    """Are the frequencies the same all round a circle of one tilt and height?"""
    ripple = 100 * facts.maps.ripple
    words = ", ".join(f"f{i} varies by {v:.2f} %" for i, v in enumerate(ripple, 1))
    otherwise = "periodic" if facts.maps.turned <= RULES.exact else "otherwise"
    return outcome(ripple.max() <= RULES.agrees_percent, otherwise, words=words)


def falls(facts: Facts, args: Args) -> Outcome:
    """Do the frequencies fall from layer to layer?"""
    steps, rising = facts.maps.steps, facts.maps.rising
    otherwise = "rise" if rising == steps else "otherwise"
    return outcome(not rising, otherwise, falling=steps - rising, **_layers(facts.maps))


def lowest_best(facts: Facts, args: Args) -> Outcome:
    """Is f1 of the level platform highest where it is lowest?"""
    z, level = facts.maps.z, facts.maps.level
    k = int(np.nanargmax(level))
    otherwise = "highest" if k == len(z) - 1 else "otherwise"
    return outcome(k == 0, otherwise, last=level[-1], best=1000 * z[k], **_layers(facts.maps))


def _layers(found: Any) -> dict[str, Any]:
    """Return the lowest and the highest layer and the largest step between layers [mm]."""
    return {"mm": 1000 * found.z[[0, -1]], "step": 1000 * np.diff(found.z).max()}
