"""Checks of Eqs. (1)-(22), of height and limbs, and of the regular workspace."""

from collections.abc import Callable
from typing import Any

import numpy as np

from harness.cases import PRESETS
from harness.signatures import Array
from harness.studies.claims.equations import PHI, STEP
from harness.studies.claims.facts import CASES, PAPER, RULES, Args, Facts, Outcome, outcome


def _vanish(*names: str) -> Callable[[Facts, Args], Outcome]:
    return lambda facts, args: outcome(
        all(getattr(facts.equations, name) <= RULES.exact for name in names)
    )


rotation, plane, lengths = _vanish("rotation"), _vanish("beside_plane"), _vanish("lengths_apart")
eq17_vertical = _vanish("axis_rise")
no_multipliers = _vanish("joints_open", "multipliers_apart")


def mobility(facts: Facts, args: Args) -> Outcome:
    """Has the platform as many freedoms as is said?"""
    return outcome(facts.equations.freedoms == args["printed"])


def angles(facts: Facts, args: Args) -> Outcome:
    """Are phi and theta angles about the y- and x-axes?"""
    alone, axis = facts.equations.phi_alone, facts.equations.theta_axis
    phi, turn, off = np.degrees([PHI, alone, axis])
    return outcome(max(axis, abs(alone - PHI)) <= RULES.exact, phi=phi, turn=turn, off=off)


def compatibility(facts: Facts, args: Args) -> Outcome:
    """Is Eq. (10) the motion of a point of a rigid body?"""
    own = STEP**2  # more than a central difference errs by
    return outcome(facts.equations.compatibility <= own, own=own)


def rod_size(facts: Facts, args: Args) -> Outcome:
    """Does Eq. (6) have a rod's size?"""
    sizes = facts.equations.sizes
    wrong = [s for s, (rod, *_) in sizes.items() if rod != 3 * 2 * (s + 1)]
    return outcome(not wrong, right=len(sizes) - len(wrong), all=len(sizes), wrong=wrong)


def dimension(facts: Facts, args: Args) -> Outcome:
    """Are there 18 s independent coordinates?"""
    sizes = facts.equations.sizes
    wrong = [s for s, (_, all_, rank, K) in sizes.items() if not 18 * s == all_ - rank == K]
    return outcome(not wrong, wrong=wrong, sizes=sizes[3], left=sizes[3][1] - sizes[3][2])


def unknowns(facts: Facts, args: Args) -> Outcome:
    """Do multipliers mean more unknowns?"""
    sizes = facts.equations.sizes[3]
    rival = sizes[1] + facts.equations.multipliers
    return outcome(rival > sizes[3], sizes=sizes, rival=rival)


def inertia(facts: Facts, args: Args) -> Outcome:
    """Can a plate of the printed thickness have the inertia of Eq. (8)?"""
    h, (jx, jy, jz) = facts.equations.thickness, facts.equations.moments
    excess, most = jx + jy - jz, h**2 / 2
    printed, disc = (facts.hertz[f"case1{own}", PAPER][2] for own in ("-printed-inertia", ""))
    holds = excess <= most * (1 + RULES.exact)
    lower = 100 * (printed / disc - 1)
    return outcome(holds, excess=excess, most=most, mm=1000 * h, lower=lower)


def base_angles(facts: Facts, args: Args) -> Outcome:
    """Does it make no difference to call all of Phi_Bi zero?"""
    changes = {case: 100 * change for case, change in facts.equations.base_clamped.items()}
    words = "; ".join(f"{case}: f1 {v[0]:+.1f} %" for case, v in changes.items())
    return outcome(np.abs([*changes.values()]).max() <= RULES.agrees_percent, words=words)


def _zero(facts: Facts, smallest: Array) -> str:
    """Return the headings [deg] at which a denominator vanishes, in words."""
    zero = np.degrees(facts.equations.headings[smallest <= RULES.exact])
    return ", ".join(f"{angle:.0f}" for angle in zero)


def eq17(facts: Facts, args: Args) -> Outcome:
    """Is Eq. (17) regular?"""
    found = facts.equations.eq17
    least, otherwise = found.min(), "here" if found[0] <= RULES.exact else "otherwise"
    return outcome(least > RULES.exact, otherwise, least=least, zero=_zero(facts, found))


def eq18(facts: Facts, args: Args) -> Outcome:
    """Is Eq. (18) singular in some configurations?"""
    singular = facts.equations.eq18.min() <= RULES.exact
    holds = singular and facts.equations.axis_motion > RULES.exact
    zero = _zero(facts, facts.equations.eq18)
    return outcome(holds, "otherwise" if singular else "nowhere", zero=zero)


def _span(facts: Facts, suffix: str = "") -> tuple[float, float]:
    """Return the shortest and the longest limb over both cases [m]."""
    both = [facts.lengths[case + suffix] for case in CASES]
    return np.min(both), np.max(both)


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
    falling = facts.maps.steps - facts.maps.rising
    otherwise = "otherwise" if falling else "rise"
    return outcome(not facts.maps.rising, otherwise, falling=falling, **_layers(facts.maps))


def lowest_best(facts: Facts, args: Args) -> Outcome:
    """Is f1 of the level platform highest where it is lowest?"""
    z, level = facts.maps.z, facts.maps.level
    k = np.nanargmax(level)
    otherwise = "highest" if k == len(z) - 1 else "otherwise"
    return outcome(k == 0, otherwise, last=level[-1], best=1000 * z[k], **_layers(facts.maps))


def _layers(found: Any) -> dict[str, Any]:
    """Return the lowest and the highest layer and the largest step between layers [mm]."""
    return {"mm": 1000 * found.z[[0, -1]], "step": 1000 * np.diff(found.z).max()}
