"""The named cases: a mechanism at a pose, and what of it was read, or fitted."""

from dataclasses import dataclass, field

import numpy as np

from analytic import InputError, Mechanism, Platform, Pose
from analytic.errors import unknown
from analytic.plausible import warn_of
from analytic.pose import one_pose
from harness.paper import Paper, Printed
from reference_models import Named


@dataclass(frozen=True)
class Case:
    """A mechanism at a pose.

    Attributes: `name`; `mechanism`; `pose`; `note`, where its numbers come from; `theory`, the
    model it is meant for; `published`, the case of the paper's Table I it stands for; `errata`,
    the ids of the errata that explain its numbers; `title`, what a figure calls it. Of a published
    table that is data: the `paper`, and what is `printed`. Raises `InputError` for anything but a
    mechanism and one pose; warns of what is hardly meant, such as GPa for Pa.
    """

    name: str
    mechanism: Mechanism
    pose: Pose
    note: str
    theory: Named = Named("euler-bernoulli", 3)  # noqa: RUF009  frozen
    published: str = ""
    errata: tuple[str, ...] = ()
    title: str = ""
    paper: Paper | None = field(default=None, repr=False)
    printed: tuple[Printed, ...] = field(default=(), repr=False)

    def __post_init__(self) -> None:
        one_pose(self.mechanism, self.pose)
        if not isinstance(self.name, str) or not self.name:
            raise InputError("Case.name", self.name, "a name")
        warn_of(self.mechanism, self.pose)

    @property
    def heading(self) -> str:
        """The case in words, for a figure."""
        return self.title or self.name


_POSES = {  # phi, theta [deg], Section 3.3
    "case1": (0.0, 0.0, "Case 1", "level platform"),
    "case2": (10.0, -12.0, "Case 2", "tilted platform"),
}


def _with_base(radius: float) -> Mechanism:
    """Return the paper's mechanism with another r1 [m]."""
    rod = Mechanism.paper().limbs[0].rod
    return Mechanism.regular(radius, 0.2, rod, Platform.disc(0.2, 0.02, rod.material.density))


def _presets() -> dict[str, Case]:
    paper, printed_inertia = Mechanism.paper(), Mechanism.paper(inertia="printed")
    euler, rayleigh = Named("euler-bernoulli", 3), Named("rayleigh", 3)
    variants = [
        ("", paper, 0.49, euler, ("height", "height-still-off"),
         "printed parameters; z = 4.9 m read as 0.49 m; platform a disc"),
        ("-as-printed", paper, 4.9, euler, ("height",),
         "printed parameters and z = 4.9 m; platform a disc"),
        ("-printed-inertia", printed_inertia, 0.49, euler, ("inertia", "height"),
         "z read as 0.49 m; platform inertia m r2^2 about all axes, Eq. 8 as printed"),
        ("-z-fitted", paper, 0.5448, euler, ("cases-disagree",),
         "z = 0.5448 m fitted to Table I, case 1; all else as printed; platform a disc"),
        ("-z-r1-fitted", _with_base(0.3371), 0.53336, rayleigh, ("case1-fit",),
         "z = 0.53336 m and r1 = 0.3371 m fitted to Table I, case 1, with section rotary inertia"),
        ("-small-base", _with_base(0.1), 0.5451, euler, ("lean",),
         "r1 = 0.1 m, limbs then lean outwards going up; z = 0.5451 m fitted to both cases"),
    ]  # fmt: skip
    cases = {}
    for suffix, mechanism, z, theory, errata, note in variants:
        for published, (azimuth, tilt, number, platform) in _POSES.items():
            name = published + suffix
            title = f"{number}{suffix.replace('-', ', ', 1).replace('-', ' ')}: {platform}"
            pose = Pose(z, np.radians(azimuth), np.radians(tilt))
            cases[name] = Case(name, mechanism, pose, note, theory, published, errata, title)
    return cases


PRESETS = _presets()


def select(names: list[str], extra: dict[str, Case]) -> list[Case]:
    """Return the cases called `names` among the presets and `extra`, or raise `InputError`."""
    known = PRESETS | extra
    for name in names:
        if name not in known:
            raise unknown("cases", name, known)
    return [known[name] for name in dict.fromkeys(names)]
