"""A mechanism at a pose, at rest or moved by a mode, as every picture of it draws it."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from analytic import STATIONS, Body, Link, Mechanism, Pose, Rod, limbs_at, position
from analytic.placed import place
from harness.signatures import Array

AMPLITUDE = 0.2
"""Largest displacement drawn, relative to the mean limb length."""
LINK = 0.012
"""Radius of a rigid link as it is drawn, relative to the mean limb length."""
RING = np.linspace(0, 2 * np.pi, 33)
"""Angles of the corners of a rod's and of the platform's rim [rad]."""


class Span(NamedTuple):
    """A rod or link of a limb from `begin` to `end`, fractions of its line; its `radius` [m]."""

    limb: int
    begin: float
    end: float
    radius: float


class Mark(NamedTuple):
    """A joint or body of a limb: its `place`, a fraction of the line, its `kind` ("R", "U", "S",
    "P", "fixed", "joint", "body"), and how far `beside` the line it is (3,) [m].
    """

    limb: int
    place: float
    kind: str
    beside: Array


@dataclass(frozen=True)
class Drawn:
    """The undeformed mechanism [m].

    Attributes: limbs from `starts`, on their sliders, to `tips`, each (n, 3); their `bases` (n, 3);
    `spans`, a rod or link each; `marks`, a joint or body each; the platform's `centre` (3,), the
    two `axes` of its plane (2, 3), its `radius` and its centre of `mass` (3,); mean `length` of the
    limbs; `plain`: whether its limbs are the paper's, which need no marks.
    """

    bases: Array
    starts: Array
    tips: Array
    spans: list[Span]
    marks: list[Mark]
    centre: Array
    axes: Array
    radius: float
    mass: Array
    length: float
    plain: bool

    def limbs(self, shift: Array | float = 0.0) -> Array:
        """Return the limbs' axes, (n, stations, 3), moved by `shift` of the same shape."""
        along = (self.tips - self.starts)[:, None]
        return np.asarray(self.starts[:, None] + STATIONS[:, None] * along + shift)

    @property
    def ground(self) -> Array:
        """The bases round the z axis, a closed line (k, 3): without those on it."""
        x, y, _ = self.bases.T
        off = np.flatnonzero(np.hypot(x, y) > 1e-9)
        around = off[np.arctan2(y[off], x[off]).round(9).argsort(kind="stable")]
        return self.bases[[*around, *around[:1]]]

    def marked(self, lines: Array) -> Array:
        """Return where the marks are on the limbs' `lines` (n, stations, 3), (marks, 3)."""
        found = [at(lines[one.limb], one.place) + one.beside for one in self.marks]
        return np.array(found).reshape(-1, 3)

    def rods(self, limbs: Array | float) -> Iterator[Array]:
        """Yield the surface of each span as a grid of points (k, 33, 3).

        `limbs`: their displacements (n, stations, 3), as large as they are drawn.
        """
        lines = self.limbs(limbs)
        for one in self.spans:
            inner = STATIONS[(one.begin < STATIONS) & (one.end > STATIONS)]
            yield tube(at(lines[one.limb], np.array([one.begin, *inner, one.end])), one.radius)

    def disc(self, platform: Array) -> Array:
        """Return the rim of a platform displaced and turned by (6,), (33, 3)."""
        arms = self.radius * np.stack([np.cos(RING), np.sin(RING)], axis=1) @ self.axes
        return self.centre + platform[:3] + arms + np.cross(platform[3:], arms)


def drawn(mechanism: Mechanism, pose: Pose) -> Drawn:
    """Return what is drawn of `mechanism` at `pose`."""
    limbs, o = limbs_at(mechanism, pose), np.asarray(position(mechanism, pose))
    length = float(limbs.lengths.mean())
    spans, marks, starts = list[Span](), list[Mark](), np.empty((len(mechanism.limbs), 3))
    for group in place(mechanism, pose):
        for k, i in enumerate(group.alike.limbs.tolist()):
            starts[i], lengths = group.starts[k, 0], group.lengths[k]
            ends = (np.concatenate([[0.0], np.cumsum(lengths)]) / lengths.sum()).tolist()
            for item, begin, end in zip(group.alike.chains[k], ends, ends[1:], strict=False):
                if isinstance(item, Link):
                    spans.append(Span(i, begin, end, LINK * length))
                elif isinstance(item, Rod):  # a section that is not round is drawn by its area
                    d = item.section.diameter or 2 * float(np.sqrt(item.area / np.pi))
                    spans.append(Span(i, begin, end, d / 2))
                elif isinstance(item, Body):
                    axes = group.frames[k] if item.frame == "limb" else np.eye(3)
                    marks.append(Mark(i, begin, "body", axes @ item.centre))
                else:
                    marks.append(Mark(i, begin, item.name, np.zeros(3)))
    return Drawn(
        bases=mechanism.bases,
        starts=starts,
        tips=o + limbs.arms,
        spans=sorted(spans, key=lambda one: (one.limb, one.begin)),
        marks=sorted(marks, key=lambda one: (one.limb, one.place)),
        centre=o,
        axes=pose.rotation.T[:2],
        radius=float(np.linalg.norm(mechanism.platform_points, axis=1).max()),
        mass=o + pose.rotation @ mechanism.platform.centre,
        length=length,
        plain=mechanism.simple,
    )


def at(line: Array, places: Array | float) -> Array:
    """Return the points of a limb's line (stations, 3) at fractions of its length, (..., 3)."""
    return np.stack([np.interp(places, STATIONS, along) for along in line.T], axis=-1)


def scale(there: Drawn, limbs: Array) -> Array:
    """Return the factors that make the largest displacement of `limbs` (..., n, stations, 3) as
    large as `AMPLITUDE` says."""
    largest = np.abs(limbs).max(axis=(-1, -2, -3), initial=0.0)
    return np.asarray(AMPLITUDE * there.length / np.maximum(largest, 1e-12))


def tube(line: Array, radius: float) -> Array:
    """Return the surface of a rod of `radius` round `line` (k, 3), closed by its two end faces, as
    points (k + 2, 33, 3)."""
    along = line[-1] - line[0]
    side = np.cross(along, np.eye(3)[np.abs(along).argmin()])
    side /= np.linalg.norm(side)
    up = np.cross(along, side) / np.linalg.norm(along)
    ring = np.cos(RING)[:, None] * side + np.sin(RING)[:, None] * up
    ends = 0 * ring[None]
    return np.concatenate([line[0] + ends, line[:, None] + radius * ring, line[-1] + ends])
