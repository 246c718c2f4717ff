"""The exact dynamic stiffness of a limb at A_i, of a continuum or of s equal elements alike.

The spherical joint leaves a limb's tip free of moment, so that its force on the platform is, in
limb axes, diag(d_x, d_y, d_z)(lambda) times the displacement, lambda = omega^2: d_x of a beam
pinned at its base (bending about the revolute axis), d_y of one clamped there, d_z of a bar. Its
torsion is a shaft fixed at the base and free at the tip, coupled to nothing.

All bending follows from two waves: see `waves`.
"""

import numpy as np
from numpy.typing import NDArray

from analytic.waves import (
    Array,
    Sections,
    Waves,
    bending_waves,
    chain_element,
    chain_tip,
    continuum_tip,
    real_tip,
    stepping,
)

CIRCLE, POINTS = 0.2, 24
"""Radius, in first poles, and points of the circle on which a series about zero is found."""


def bending_stiffness(waves: Waves) -> tuple[Array, Array, Array]:
    """Return d_x (pinned base), d_y (clamped base) [N/m] and the clamp's rotational stiffness.

    The last is M / theta at the base of a beam pinned at both ends (units of the waves); it is
    negative where clamping removes a fixed-tip mode from below lambda.
    """
    (n1, n2), (f1, f2), (h1, h2) = waves.n, waves.f, waves.h
    (K1, K2), (x1, x2), (e1, e2) = waves.K, waves.kappa, waves.eta
    pinned = (f1 * h2 * x1 - f2 * h1 * x2) / (h2 - h1)
    nodes = n1 * x1 - n2 * x2
    clamped = (
        x1 * x2 * (h1 * f2 * n1 + h2 * f1 * n2)
        - e1 * e2 * (h1 * f1 * n2 + h2 * f2 * n1)
        - (h1 * n2 * f2 * K2 + h2 * n1 * f1 * K1)
    ) / ((h1 - h2) * nodes)
    return pinned, clamped, (h1 - h2) / nodes


def axial_stiffness(
    rods: Sections, lengths: Array, eigenvalue: Array, elements: int | None
) -> Array:
    """Return d_z = EA k cot(k L) [N/m], complex, or its like for linear bars."""
    if elements is None:
        tip = real_tip if stepping(eigenvalue) and stepping(lengths) else continuum_tip
        return rods.EA * tip(-eigenvalue / rods.axial_speed2, lengths)[0]
    length = lengths / elements
    x = eigenvalue * length**2 / rods.axial_speed2
    kappa, _ = chain_tip(-x / (2 * (1 + x / 6)), elements)
    return rods.EA / length * (1 + x / 6) * kappa


def limb_response(
    rods: Sections, lengths: Array, eigenvalue: Array, elements: int | None
) -> tuple[Array, NDArray[np.int64]]:
    """Return (d_x, d_y, d_z) [N/m] and how many modes have the tip held, both (..., n, 3).

    What `limb_stiffness` and `fixed_tip_counts` return, of one evaluation: a d_k is positive just
    above the same pole that its count has just passed, to the last digit.
    """
    waves = bending_waves(rods, lengths, eigenvalue, elements)
    pinned, clamped, clamp = bending_stiffness(waves)
    axial = axial_stiffness(rods, lengths, eigenvalue, elements)
    if elements is None:
        families = _passed(waves.K, waves.kappa, lengths)
        # Above the cut-on a second family starts, with the shear mode w = 0 as its first member.
        held = families[0] + families[1] + (waves.K[0].real < 0)
        stretched = _passed(-eigenvalue / rods.axial_speed2, axial, lengths)
    else:
        held = _pinned_chain_count(rods, lengths, np.real(eigenvalue), elements)
        stretched, _ = _bar_counts(rods.axial_speed2, lengths, np.real(eigenvalue), elements)
    # Pinned-pinned modes have closed forms; a clamp at the base takes one of them away where the
    # base's rotational stiffness is negative.
    counts = np.stack([held, held - (clamp.real < 0), stretched], axis=-1)
    return np.stack([pinned, clamped, axial], axis=-1), counts.astype(np.int64)


def _passed(K: Array, kappa: Array, length: Array) -> Array:
    """Return how many poles of kappa = k cot(k L) lie below, one at each multiple of pi."""
    half_waves = np.sqrt(np.maximum(-np.real(K), 0.0)) * np.real(length) / np.pi
    nearest = np.rint(half_waves)
    # Next to a pole the sign of kappa says on which side of it rounding has put this one.
    beside = np.abs(half_waves - nearest) < 0.25
    return np.asarray(np.where(beside, nearest - (kappa.real < 0), np.floor(half_waves)))


def limb_stiffness(
    rods: Sections, lengths: Array, eigenvalue: Array, elements: int | None
) -> Array:
    """Return (d_x, d_y, d_z) of every limb [N/m], shape (..., n, 3); complex of complex input."""
    pinned, clamped, _ = bending_stiffness(bending_waves(rods, lengths, eigenvalue, elements))
    axial = axial_stiffness(rods, lengths, eigenvalue, elements)
    return np.stack(np.broadcast_arrays(pinned, clamped, axial), axis=-1)


def fixed_tip_counts(
    rods: Sections, lengths: Array, eigenvalue: Array, elements: int | None
) -> NDArray[np.int64]:
    """Return how many modes each limb has below `eigenvalue` with its tip held at A_i.

    Shape (..., n, 4): bending about the revolute axis, bending across it, axial, torsion; J_0 of
    Wittrick and Williams (1971) is their sum.
    """
    _, counts = limb_response(rods, lengths, eigenvalue, elements)
    torsion = torsion_counts(rods, lengths, eigenvalue, elements)
    return np.concatenate([counts, np.broadcast_to(torsion, counts.shape[:-1])[..., None]], axis=-1)


def torsion_counts(
    rods: Sections, lengths: Array, eigenvalue: Array, elements: int | None
) -> NDArray[np.int64]:
    """Return how many modes of torsion each limb has below `eigenvalue`, shape (..., n)."""
    counts = _bar_counts(rods.torsion_speed2, lengths, eigenvalue, elements)[1]
    return np.asarray(counts).astype(np.int64)


def _pinned_chain_count(
    rods: Sections, lengths: Array, eigenvalue: Array, s: int
) -> NDArray[np.int64]:
    """Count by families w_j ~ sin(j m pi / s), theta_j ~ cos(j m pi / s), m = 0..s."""
    length = np.asarray(lengths)[..., None] / s
    wide = Sections(*(np.asarray(value)[:, None] for value in vars(rods).values()))
    Lam = np.asarray(eigenvalue)[..., None] * wide.line_mass * length**4 / wide.EI
    stiff, mass = chain_element(wide, length)
    _, _, t, v, r, y = (a - Lam * b for a, b in zip(stiff, mass, strict=True))
    angle = np.pi * np.arange(s + 1) / s
    # p + t cos = (p + t) - 2 t sin^2(angle / 2): the statics cancel exactly in p + t.
    across = -Lam * (mass[0] + mass[2]) - 2 * t * np.sin(angle / 2) ** 2
    along = y * np.cos(angle) + r
    determinant = across * along - (v * np.sin(angle)) ** 2
    inner = np.where(determinant < 0, 1, np.where(along < 0, 2, 0))
    inner[..., [0, s]] = along[..., [0, s]] < 0
    return np.asarray(inner.sum(axis=-1))


def _bar_counts(
    speed2: Array, lengths: Array, eigenvalue: Array, elements: int | None
) -> tuple[Array, Array]:
    """Count the modes of a bar below `eigenvalue`: both ends fixed, and its tip free."""
    if elements is None:
        half_waves = np.sqrt(eigenvalue / speed2) * lengths / np.pi
        return np.ceil(half_waves) - 1, np.ceil(half_waves - 0.5)
    x = eigenvalue * (lengths / elements) ** 2 / speed2
    sine = np.minimum(np.sqrt(x / (4 * (1 + x / 6))), 1.0)
    half_waves = elements * 2 * np.arcsin(sine) / np.pi
    fixed = np.minimum(np.ceil(half_waves) - 1, elements - 1)
    return fixed, np.ceil(np.minimum(half_waves - 0.5, elements - 0.5))


def static_stiffness(rods: Sections, lengths: Array) -> Array:
    """Return d_x = 0, d_y = 3 EI / L^3 (1 + Phi / 4) and d_z = EA / L at rest, (..., n, 3) [N/m].

    Phi = 12 EI / (kappa G A L^2). Elements have the same: their interpolation is exact in statics.
    """
    clamped = 3 * rods.EI / (lengths * (lengths**2 + rods.flexibility / 4))
    return np.stack([np.zeros_like(clamped), clamped, rods.EA / lengths], axis=-1)


def first_pole(rods: Sections, lengths: Array) -> Array:
    """Return omega^2 of each limb's first bending mode between pins, (..., n) [1/s^2].

    Without elements; clamped at the base the first mode is higher.
    """
    p = (np.pi / lengths) ** 2
    shear = rods.line_mass * rods.flexibility / (12 * rods.EI)
    rotary = rods.line_inertia / rods.EI
    b = (shear + rotary) * p + rods.line_mass / rods.EI
    return np.asarray(2 * p**2 / (b + np.sqrt(b**2 - 4 * shear * rotary * p**2)))


def softening_series(rods: Sections, lengths: Array, elements: int | None, terms: int) -> Array:
    """Return c_1 ... of d_k(lambda) = d_k(0) + sum_j c_j (lambda / first pole)^j of bending [N/m].

    Shape (terms, ..., n, 2). By Cauchy's integral on a circle where the closed forms lose no
    digits, as they do near zero.
    """
    circle = CIRCLE * np.exp(2j * np.pi * (np.arange(POINTS) + 0.5) / POINTS)
    pole = first_pole(rods, lengths)
    around = circle.reshape(-1, *([1] * pole.ndim)) * pole
    values = np.stack(bending_stiffness(bending_waves(rods, lengths, around, elements))[:2], -1)
    powers = circle[None, :] ** -np.arange(1, terms + 1)[:, None]
    return np.asarray(np.tensordot(powers, values, axes=1).real / POINTS)


def torsion_eigenvalues(rods: Sections, lengths: Array, count: int, elements: int | None) -> Array:
    """Return omega^2 of every limb's torsion modes, at most `count`, shape (..., n, k)."""
    speed2, length = rods.torsion_speed2[:, None], np.asarray(lengths)[..., None]
    if elements is None:
        return np.asarray(((np.arange(count) + 0.5) * np.pi / length) ** 2 * speed2)
    s = elements
    angle = (np.arange(min(count, s)) + 0.5) * np.pi / s
    return np.asarray(
        12 * np.sin(angle / 2) ** 2 / (2 + np.cos(angle)) * speed2 * (s / length) ** 2
    )
