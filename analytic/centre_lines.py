"""How limbs without elements move between their ends."""

import numpy as np

from analytic.modes import STATIONS
from analytic.waves import bending_waves
from analytic.wittrick_williams import Characteristic, Floats

STRAIGHT = 1e-9
"""Below this part of a limb's first pole, shapes are those at it: they differ by no more."""


def centre_lines(problem: Characteristic, omega2: Floats, w: Floats, force: Floats) -> Floats:
    """Return displacement in limb axes at `STATIONS`, shape (m, n, 11, 3), of m modes.

    From `omega2` (m,) and motion `w` and `force` of the tips (m, n, 3). A limb's motion between is
    known up to a factor, taken from both together: at a fixed-tip mode w is zero, at a free-tip
    mode the force is.
    """
    rods, lengths, scale = problem.rods, problem.lengths, problem.scale
    omega2 = np.maximum(omega2, STRAIGHT * problem.first)[:, None]
    waves = bending_waves(rods, lengths, omega2, None)
    K, n, f, h = (np.moveaxis(x, 0, -1) for x in (waves.K, waves.n, waves.f, waves.h))
    k, x = np.sqrt(K + 0j)[:, :, None, :], STATIONS[:, None] * lengths[:, None, None]
    # Of each wave one part decays from the base and one from the tip: nothing overflows.
    rest = lengths[:, None, None] - x
    line = np.concatenate([np.exp(-k * x), np.exp(-k * rest)], axis=-1)
    sign = np.array([-1.0, -1.0, 1.0, 1.0])
    k = k[:, :, 0]
    theta, shear, moment = (
        np.concatenate([part, part], axis=-1) * by
        for part, by in ((n * k, sign), (f * k, sign), (h, 1.0))
    )
    base, tip = line[:, :, 0], line[:, :, -1]
    # The base moves nowhere, and is free to turn about y and clamped about x; the tip is free.
    conditions = np.stack(
        [np.stack([base, base * turning, tip * moment], axis=-2) for turning in (moment, theta)],
        axis=2,
    )
    conditions /= np.linalg.norm(conditions, axis=-1, keepdims=True)
    amplitude = np.linalg.svd(conditions)[2][..., -1, :].conj()
    own = (line[:, :, None] @ amplitude[..., None])[..., 0]
    forces = ((tip * shear)[:, :, None] * amplitude).sum(axis=-1)
    bending = _fitted(own, forces, w[..., :2], force[..., :2], scale[:, :2])
    k_z = np.sqrt(omega2 / rods.axial_speed2)
    own = np.sin(k_z[..., None] * STATIONS * lengths[:, None])[:, :, None]
    forces = (rods.EA * k_z * np.cos(k_z * lengths))[..., None]
    along = _fitted(own, forces, w[..., 2:], force[..., 2:], scale[:, 2:])
    return np.concatenate([bending, along], axis=2).swapaxes(2, 3)


def _fitted(own: Floats, force: Floats, w: Floats, wanted: Floats, scale: Floats) -> Floats:
    """Return motions `own` (m, n, c, 11) times the factor that fits w and force best."""
    tip = own[..., -1] * scale
    product = w * scale * tip.conj() + wanted * force.conj()
    factor = product / (np.abs(tip) ** 2 + np.abs(force) ** 2)
    return np.asarray((factor[..., None] * own).real)
