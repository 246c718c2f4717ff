"""A mechanism at a pose, at rest or moved by a mode, as every picture of it draws it."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from analytic import STATIONS, Body, Link, Mechanism, Pose, Rod, limbs_at, position
from analytic.placed import place
from harness.signatures import Array

AMPLITUDE = 0.2
"""Largest displacement drawn, relative to the mean limb length."""
LINK = 0.012
"""Radius of a rigid link as it is drawn, relative to the mean limb length."""
TURN, HEIGHT = np.radians(-60), np.radians(18)
"""From where a mechanism is looked at: azimuth and elevation [rad]."""
RING = np.linspace(0, 2 * np.pi, 33)
"""Angles of the corners of a rod's and of the platform's rim [rad]."""


@dataclass(frozen=True)
class Span:
    """A rod or link of a limb from `begin` to `end`, fractions of its line; its `radius` [m]."""

    limb: int
    begin: float
    end: float
    radius: float


@dataclass(frozen=True)
class Mark:
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
    spans: tuple[Span, ...]
    marks: tuple[Mark, ...]
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
        return np.array([
            at(lines[one.limb], np.array([one.place]))[0] + one.beside for one in self.marks
        ]).reshape(-1, 3)  # fmt: skip

    def rim(self) -> Array:
        """Return the arms from the platform's centre to its rim, (33, 3)."""
        return self.radius * np.stack([np.cos(RING), np.sin(RING)], axis=1) @ self.axes

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
        arms = self.rim()
        return self.centre + platform[:3] + arms + np.cross(platform[3:], arms)


def drawn(mechanism: Mechanism, pose: Pose) -> Drawn:
    """Return what is drawn of `mechanism` at `pose`."""
    limbs, o = limbs_at(mechanism, pose), np.asarray(position(mechanism, pose))
    spans: list[Span] = []
    marks: list[Mark] = []
    starts = np.empty((len(mechanism.limbs), 3))
    for group in place(mechanism, pose):
        for i, chain, lengths, first in zip(
            group.alike.limbs.tolist(), group.alike.chains, group.lengths, group.starts, strict=True
        ):
            starts[i] = first[0]
            ends = np.concatenate([[0.0], np.cumsum(lengths)]) / lengths.sum()
            for item, begin, end in zip(chain, ends, ends[1:], strict=False):
                if isinstance(item, (Rod, Link)):
                    spans.append(Span(i, float(begin), float(end), _radius(item, limbs.lengths)))
                elif isinstance(item, Body):
                    axes = group.frames[group.alike.limbs.tolist().index(i)]
                    beside = axes @ item.centre if item.frame == "limb" else np.array(item.centre)
                    marks.append(Mark(i, float(begin), "body", beside))
                else:
                    marks.append(Mark(i, float(begin), item.name, np.zeros(3)))
    return Drawn(
        mechanism.bases,
        starts,
        o + limbs.arms,
        tuple(sorted(spans, key=lambda one: (one.limb, one.begin))),
        tuple(sorted(marks, key=lambda one: (one.limb, one.place))),
        o,
        pose.rotation.T[:2],
        float(np.linalg.norm(mechanism.platform_points, axis=1).max()),
        o + pose.rotation @ mechanism.platform.centre,
        float(limbs.lengths.mean()),
        mechanism.simple,
    )


def _radius(item: Rod | Link, lengths: Array) -> float:
    """Return how thick an item is drawn: a section that is not round by its area."""
    if isinstance(item, Link):
        return LINK * float(lengths.mean())
    d = item.section.diameter
    return float(np.sqrt(item.area / np.pi)) if d is None else d / 2


def at(line: Array, places: Array) -> Array:
    """Return the points of a limb's line (stations, 3) at fractions of its length, (k, 3)."""
    return np.stack([np.interp(places, STATIONS, line[:, c]) for c in range(3)], axis=1)


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
    return np.concatenate(
        [line[0] + 0 * ring[None], line[:, None] + radius * ring, line[-1] + 0 * ring[None]]
    )


def seen(points: Array) -> tuple[Array, Array]:
    """Return `points` (..., 3) from the front: right and up (..., 2), and how near (...)."""
    front = np.array([np.cos(TURN), np.sin(TURN), 0.0])
    right = np.array([-front[1], front[0], 0.0])
    towards = np.cos(HEIGHT) * front + np.sin(HEIGHT) * np.eye(3)[2]
    return points @ np.stack([right, np.cross(towards, right)], axis=1), points @ towards
