"""Checks of Eqs. (1)-(22): what each says, against what it must satisfy."""

from collections.abc import Callable

import numpy as np

from harness.signatures import Array
from harness.studies.claims.data import RULES, Args, Outcome, outcome
from harness.studies.claims.equations import PHI, STEP
from harness.studies.claims.facts import PAPER, Facts


def _vanish(*fields: str) -> Callable[[Facts, Args], Outcome]:
    def check(facts: Facts, args: Args) -> Outcome:
        return outcome(all(getattr(facts.equations, name) <= RULES.exact for name in fields))

    return check


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
    holds = axis <= RULES.exact and abs(alone - PHI) <= RULES.exact
    return outcome(holds, phi=phi, turn=turn, off=off)


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
    hertz, h = facts.hertz, facts.equations.thickness
    jx, jy, jz = facts.equations.moments
    excess, most = jx + jy - jz, h**2 / 2
    lower = 100 * (hertz["case1-printed-inertia", PAPER][2] / hertz["case1", PAPER][2] - 1)
    holds = excess <= most * (1 + RULES.exact)
    return outcome(holds, excess=excess, most=most, mm=1000 * h, lower=lower)


def base_angles(facts: Facts, args: Args) -> Outcome:
    """Does it make no difference to call all of Phi_Bi zero?"""
    changes = {case: 100 * change for case, change in facts.equations.base_clamped.items()}
    largest = max(np.abs(v).max() for v in changes.values())
    words = "; ".join(f"{case}: f1 {v[0]:+.1f} %" for case, v in changes.items())
    return outcome(largest <= RULES.agrees_percent, words=words)


def _zero(facts: Facts, smallest: Array) -> str:
    """Return the headings [deg] at which a denominator vanishes, in words."""
    zero = np.degrees(facts.equations.headings[smallest <= RULES.exact])
    return ", ".join(f"{angle:.0f}" for angle in zero)


def eq17(facts: Facts, args: Args) -> Outcome:
    """Is Eq. (17) regular?"""
    found = facts.equations.eq17
    otherwise = "here" if found[0] <= RULES.exact else "otherwise"
    holds = found.min() > RULES.exact
    return outcome(holds, otherwise, least=found.min(), zero=_zero(facts, found))


def eq18(facts: Facts, args: Args) -> Outcome:
    """Is Eq. (18) singular in some configurations?"""
    found = facts.equations.eq18
    singular = found.min() <= RULES.exact
    holds = singular and facts.equations.axis_motion > RULES.exact
    return outcome(holds, "otherwise" if singular else "nowhere", zero=_zero(facts, found))
