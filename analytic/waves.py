"""The waves of bending that a limb's exact stiffness is made of, of beams and of element chains.

With cosh(alpha) of either of two, C_j = cosh(j alpha) and S_j = sinh(j alpha) / sinh(alpha) at node
j, all bending is
    w = A C + B S,  theta = n (A K S + B C),  F = f (A K S + B C),  M = h (A C + B S),
K = sinh(alpha)^2; for a continuum sinh(alpha) is replaced by the wave number k and j alpha by
k x. Howson and Williams (1973) give the continuum; the waves of an element chain are its discrete
dispersion relation, so that their number never enters the cost.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError
from analytic.mechanism import Mechanism, Rod
from analytic.rod_elements import bending_numbers, properties
from analytic.theory import Theory

Array = NDArray[Any]
"""Real, or complex where a derivative is taken by complex step."""


@dataclass(frozen=True)
class Sections:
    """What the limbs' sections resist and weigh; every entry has shape (n,), a value a limb.

    Attributes: `EA` [N], `EI` [N m^2], `line_mass` rho A [kg/m], `line_inertia` rho I [kg m] (zero
    without rotary inertia), `flexibility` 12 EI / (kappa G A) [m^2] (zero without shear),
    `axial_speed2` E / rho and `torsion_speed2` G / rho [m^2/s^2].
    """

    EA: Array
    EI: Array
    line_mass: Array
    line_inertia: Array
    flexibility: Array
    axial_speed2: Array
    torsion_speed2: Array


def sections(mechanism: Mechanism, theory: Theory) -> Sections:
    """Return the limbs' sections under `theory`; raises as `paper_rods`."""
    rods = paper_rods(mechanism)
    of = properties(rods, theory).alike()
    young, shear, density = np.array(
        [(rod.material.young, rod.material.shear, rod.material.density) for rod in rods]
    ).T
    bending = of.EI[:, 0], of.mass, of.rotary[:, 0], 12 * of.shear[:, 0]
    return Sections(of.EA, *bending, young / density, shear / density)


def paper_rods(mechanism: Mechanism) -> list[Rod]:
    """Return the rods of the paper's limbs.

    Raises `InputError` for other limbs than the paper's, or a centre of mass off o.
    """
    if any(mechanism.platform.centre):
        raise InputError("Platform.centre", mechanism.platform.centre, "o itself for this model")
    return [limb.rod for limb in mechanism.limbs]


@dataclass(frozen=True)
class Waves:
    """The two bending waves (first axis) at lambda, as in the module's equations.

    `kappa` = C / S and `eta` = 1 / S at the tip.
    """

    K: Array
    n: Array
    f: Array
    h: Array
    kappa: Array
    eta: Array


def bending_waves(rods: Sections, lengths: Array, eigenvalue: Array, elements: int | None) -> Waves:
    """Return the bending waves of limbs of `lengths` [m] at `eigenvalue` = omega^2 > 0.

    A wave that travels has K < 0, on either side of the cut-on frequency. `lengths` (..., n) and
    `eigenvalue` broadcast against each other; either may be complex.
    """
    real = stepping(eigenvalue) and stepping(lengths)
    lengths, lam = np.broadcast_arrays(lengths, eigenvalue)
    if elements is None:
        return _continuum_waves(rods, lengths, lam, real)
    return _chain_waves(rods, lengths, lam, elements)


def _continuum_waves(rods: Sections, lengths: Array, lam: Array, real: bool) -> Waves:
    # theta' = G w with G^2 + lambda (rhoI/EI - sigma) G - lambda rhoA/EI = 0, k^2 = G - lambda
    # sigma, sigma = rhoA / (kappa G A). Each root is taken where nothing cancels.
    mass = lam * (rods.line_mass / rods.EI)
    shear = mass * (rods.flexibility / 12)
    rotary = lam * (rods.line_inertia / rods.EI)
    b = rotary - shear
    # Of real lambda both roots are real, and so is all that follows.
    root = np.sqrt(b * b + (4 * mass if real else 4 * mass + 0j))
    larger = -(b + np.where(b.real < 0, -root, root)) / 2
    other = -mass / larger
    ordered = larger.real > other.real
    G = np.stack([np.where(ordered, larger, other), np.where(ordered, other, larger)])
    K2 = G[1] - shear
    K1 = -mass * (1 - rotary * rods.flexibility / 12) / K2
    K1 = np.where(np.abs(K1) < TINY * np.abs(K2), TINY * np.abs(K2), K1)
    K = np.stack([K1, K2])
    kappa, eta = real_tip(K, lengths) if real else continuum_tip(K, lengths)
    return Waves(K, G / K, -lam * rods.line_mass / K, rods.EI * G, kappa, eta)


def _chain_waves(rods: Sections, lengths: Array, lam: Array, s: int) -> Waves:
    # An element's E = k - Lambda m in units of EI / h^3, over (w, h theta) of its two nodes, is
    # [[p, q, t, v], [q, r, -v, y], [t, -v, p, -q], [v, y, -q, r]] by its symmetry.
    length = lengths / s
    Lam = lam * rods.line_mass * length**4 / rods.EI
    stiff, mass = chain_element(rods, length)
    (_, q, t, v, r, y), (pm, qm, tm, vm, rm, ym) = stiff, mass
    # Equilibrium of a node, ((p + t) + t e) ((y + r) + y e) + v^2 e (2 + e) = 0 in e = cosh - 1.
    # What the statics cancel exactly is left out, so that many elements lose no digits.
    pt, vq = -Lam * (pm + tm), -Lam * (vm - qm)
    yr = (y + r) - Lam * (ym + rm)
    ty_r = -Lam * (t * (ym + rm) + tm * (y + r)) + Lam**2 * tm * (ym + rm)
    v2 = -2 * Lam * v * vm + Lam**2 * vm**2
    vv_q = -Lam * (v * (vm + qm) + (v + q) * vm) + Lam**2 * vm * (vm + qm)
    T, V, Y = t - Lam * tm, v - Lam * vm, y - Lam * ym
    a = T * Y + V**2
    e = np.stack(_quadratic((ty_r + Y * pt + 2 * v2) / a, pt * yr / a))
    slope = yr + Y * e
    n = V / slope
    f = -(ty_r + vv_q + e * a) / slope
    h = vq + e * (V - Y * n * (2 + e))
    kappa, eta = chain_tip(e, s)
    unit = rods.EI / length**3
    return Waves(e * (2 + e), n, unit * f, h, kappa, eta)


def chain_element(rods: Sections, length: Array) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Return (p, q, t, v, r, y) of an element's bending stiffness and of its mass.

    For arrays of `length` h [m]; see `bending_numbers`.
    """
    return bending_numbers(
        rods.flexibility / length**2, rods.line_inertia / (rods.line_mass * length**2)
    )


def _quadratic(b: Array, c: Array) -> tuple[Array, Array]:
    """Return the two roots of x^2 + b x + c, complex, without cancellation."""
    root = np.sqrt(b * b - 4 * c + 0j)
    larger = -(b + np.where(b.real < 0, -root, root)) / 2
    return larger, c / larger


NEARLY_REAL = 1e-9
"""A smaller relative imaginary part is a complex step: its square is beyond the last digit."""
TINY = 1e-16
"""Where a wave's K vanishes, cosh = 1 + TINY stands for cosh = 1: all limits there are smooth."""


def continuum_tip(K: Array, length: Array) -> tuple[Array, Array]:
    """Return kappa = k coth(k L) and eta = k / sinh(k L), k^2 = K."""
    K, length = np.broadcast_arrays(K, length)
    k, L = np.sqrt(_base(K) + 0j), _base(length)
    kappa, eta = _hyperbolic(k, k * L)
    by_K = (kappa - L * eta**2) / (2 * K), eta * (1 - L * kappa) / (2 * K)
    by_L = -(eta**2), -eta * kappa
    return (
        _stepped(kappa, (K, by_K[0]), (length, by_L[0])),
        _stepped(eta, (K, by_K[1]), (length, by_L[1])),
    )


def real_tip(K: Array, length: Array) -> tuple[Array, Array]:
    """Return what `continuum_tip` does where K is real but for a complex step."""
    travels = K.real < 0
    k = np.sqrt(np.where(travels, -K, K))
    y = k * length
    decaying = np.where(travels, 1.0, y)
    e, one_minus = np.exp(-decaying), -np.expm1(-2 * decaying)
    sine, cosine = np.sin(y), np.cos(y)
    # A phase that rounds to a multiple of pi is a pole passed by less than the last digit.
    sine = np.where(sine == 0, TINY, sine)
    kappa = k * np.where(travels, cosine / sine, (1 + e * e) / one_minus)
    return kappa, k * np.where(travels, 1 / sine, 2 * e / one_minus)


def stepping(x: Array) -> bool:
    """Return whether `x` is real but for complex steps."""
    return not np.iscomplexobj(x) or bool(_is_step(x).all())


def chain_tip(e: Array, s: int) -> tuple[Array, Array]:
    """Return kappa = sinh(alpha) coth(s alpha) and eta, cosh(alpha) = 1 + e."""
    # kappa is odd and eta even or odd in cosh(alpha): both ends of the band are exact alike.
    flipped = e.real < -1
    e = np.where(flipped, -2 - e, e)
    e = np.where(np.abs(e) < TINY, TINY, e)
    half = np.sqrt(_base(e) / 2 + 0j)
    kappa, eta = _hyperbolic(2 * half * np.sqrt(1 + half**2), s * 2 * np.arcsinh(half))
    K = e * (2 + e)
    kappa, eta = (
        _stepped(kappa, (e, ((1 + e) * kappa - s * eta**2) / K)),
        _stepped(eta, (e, eta * (1 + e - s * kappa) / K)),
    )
    return np.where(flipped, -kappa, kappa), np.where(flipped, (-1) ** (s - 1) * eta, eta)


def _hyperbolic(scale: Array, argument: Array) -> tuple[Array, Array]:
    """Return scale * coth(argument) and scale / sinh(argument); Re(argument) >= 0: no overflow."""
    e = np.exp(-argument)
    one_minus = -np.expm1(-2 * argument)
    return scale * (1 + e * e) / one_minus, 2 * scale * e / one_minus


def _is_step(x: Array) -> Array:
    return np.asarray(np.abs(x.imag) <= NEARLY_REAL * np.abs(x.real))


def _base(x: Array) -> Array:
    """Return `x` without its complex step."""
    return np.where(_is_step(x), x.real, x) if np.iscomplexobj(x) else x


def _stepped(value: Array, *steps: tuple[Array, Array]) -> Array:
    """Return `value` moved along the complex step of its arguments, by its derivatives.

    kappa and eta are real for real K, but through imaginary exponents: rounding there would drown
    a step's imaginary part.
    """
    real = np.logical_and.reduce([_is_step(x) for x, _ in steps])
    moved = sum(x.imag * slope.real for x, slope in steps)
    return np.where(real, value.real + 1j * moved, value)
