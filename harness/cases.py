"""The named cases: a mechanism at a pose, and what of it was read, or fitted."""

from dataclasses import dataclass

import numpy as np

from analytic import InputError, Mechanism, Platform, Pose


@dataclass(frozen=True)
class Case:
    """A mechanism at a pose.

    Attributes: `name`; `mechanism`; `pose`; `note`, where its numbers come from; `model`, the
    analytic model it is meant for; `published`, the case of the paper's Table I it stands for;
    `errata`, the ids of the errata that explain its numbers.
    """

    name: str
    mechanism: Mechanism
    pose: Pose
    note: str
    model: str = "euler-bernoulli@3"
    published: str = ""
    errata: tuple[str, ...] = ()


_ANGLES = {"case1": (0.0, 0.0), "case2": (10.0, -12.0)}  # phi, theta [deg], Section 3.3


def _with_base(radius: float) -> Mechanism:
    """Return the paper's mechanism with another r1 [m]."""
    rod = Mechanism.paper().limbs[0].rod
    return Mechanism.regular(radius, 0.2, rod, Platform.disc(0.2, 0.02, rod.material.density))


def _presets() -> dict[str, Case]:
    paper, printed_inertia = Mechanism.paper(), Mechanism.paper(inertia="printed")
    variants = [
        ("", paper, 0.49, "euler-bernoulli@3", ("height", "height-still-off"),
         "printed parameters; z = 4.9 m read as 0.49 m; platform a disc"),
        ("-as-printed", paper, 4.9, "euler-bernoulli@3", ("height",),
         "printed parameters and z = 4.9 m; platform a disc"),
        ("-printed-inertia", printed_inertia, 0.49, "euler-bernoulli@3", ("inertia", "height"),
         "z read as 0.49 m; platform inertia m r2^2 about all axes, Eq. 8 as printed"),
        ("-z-fitted", paper, 0.5448, "euler-bernoulli@3", ("cases-disagree",),
         "z = 0.5448 m fitted to Table I, case 1; all else as printed; platform a disc"),
        ("-z-r1-fitted", _with_base(0.3371), 0.53336, "rayleigh@3", ("case1-fit",),
         "z = 0.53336 m and r1 = 0.3371 m fitted to Table I, case 1, with section rotary inertia"),
        ("-small-base", _with_base(0.1), 0.5451, "euler-bernoulli@3", ("lean",),
         "r1 = 0.1 m, limbs then lean outwards going up; z = 0.5451 m fitted to both cases"),
    ]  # fmt: skip
    cases = {}
    for suffix, mechanism, z, model, errata, note in variants:
        for published, (azimuth, tilt) in _ANGLES.items():
            name = published + suffix
            pose = Pose(z, np.radians(azimuth), np.radians(tilt))
            cases[name] = Case(name, mechanism, pose, note, model, published, errata)
    return cases


PRESETS = _presets()


def select(names: list[str], extra: dict[str, Case]) -> list[Case]:
    """Return the cases called `names` among the presets and `extra`, or raise `InputError`."""
    known = PRESETS | extra
    for name in names:
        if name not in known:
            raise InputError("--cases", name, f"one of {', '.join(known)}")
    return [known[name] for name in dict.fromkeys(names)]
