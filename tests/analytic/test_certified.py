"""Every bracket of the exact model holds its mode: counts at both ends in fifty digits.

The counts share nothing with the model but Mechanism, Pose and Theory's constants. A limb is cut
into pieces so short that none has a mode of its own below the frequency; each piece is the
exponential of the beam equations, and negative pivots are counted, with no closed form, no pole
and no count of a limb's own modes.
"""

import mpmath
import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from analytic import Continuum, InputError, Limb, Material, Mechanism, Platform, Pose, Rod
from analytic.errors import NotCertifiedError

STEEL = Material(200e9, 77e9, 7820.0)
DIGITS = 50


def exact_count(mechanism, pose, model, hertz):
    """Return how many modes lie below `hertz`, torsion included, in 50 digits."""
    with mp.workdps(DIGITS):
        omega2 = (2 * mp.pi * mpf(float(hertz))) ** 2
        D = mp.zeros(6)
        for i in range(3):
            D[i, i] = -omega2 * mpf(mechanism.platform.mass)
            for j in range(3):
                D[3 + i, 3 + j] = -omega2 * mpf(mechanism.platform.inertia[i][j])
        below = 0
        for limb, length, frame, point in closed(mechanism, pose):
            held, stiffness = limb_count(limb.rod, length, omega2, model.theory)
            below += held
            for d, c in zip(stiffness, frame, strict=True):
                a = [*c, *cross(point, c)]
                for i in range(6):
                    for j in range(6):
                        D[i, j] += d * a[i] * a[j]
        return below + negative_pivots(D, 6)[0]


def closed(mechanism, pose):
    """Yield every limb, its length, its axes x, y, z and A_i, both in the moving frame."""
    phi, theta, z = mpf(pose.azimuth), mpf(pose.tilt), mpf(pose.z)
    c, s, ct, st_ = mp.cos(phi), mp.sin(phi), mp.cos(theta), mp.sin(theta)
    turn = mp.matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    R = turn * mp.matrix([[ct, 0, st_], [0, 1, 0], [-st_, 0, ct]]) * turn.T
    axes = [mp.matrix(limb.axis) / mp.norm(mp.matrix(limb.axis)) for limb in mechanism.limbs]
    arms = [R * mp.matrix(limb.platform_point) for limb in mechanism.limbs]
    bases = [mp.matrix(limb.base) for limb in mechanism.limbs]
    rows = [(e[0], e[1], -dot(e, a - b) - e[2] * z) for e, a, b in zip(axes, arms, bases)]  # noqa: B905
    xx, xy, yy, bx, by = (
        sum(r[i] * r[j] for r in rows) for i, j in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2))
    )
    det, size = xx * yy - xy * xy, xx + yy
    if det > mpf("1e-17") * size**2:
        o = mp.matrix([(yy * bx - xy * by) / det, (xx * by - xy * bx) / det, z])
    elif size > 0:  # axes of one direction leave the other to the shortest o
        o = mp.matrix([bx / size, by / size, z])
    else:
        o = mp.matrix([0, 0, z])
    for limb, e, a, b in zip(mechanism.limbs, axes, arms, bases, strict=True):
        vector = o + a - b
        length = mp.norm(vector)
        along = vector / length
        x = mp.matrix(cross(e, along))
        x /= mp.norm(x)
        y = mp.matrix(cross(along, x))
        frame = [list(R.T * v) for v in (x, y, along)]
        yield limb, length, frame, [mpf(v) for v in limb.platform_point]


def limb_count(rod, length, omega2, theory):
    """Return how many modes a limb has with its tip held, and d_x, d_y, d_z."""
    E, rho = mpf(rod.material.young), mpf(rod.material.density)
    A, second = mp.pi * mpf(rod.diameter) ** 2 / 4, mp.pi * mpf(rod.diameter) ** 4 / 64
    give = rotary = mpf(0)
    if theory.beam == "timoshenko":
        kappa = mpf(theory.shear_coefficient(rod.material))
        give = 1 / (kappa * mpf(rod.material.shear) * A)
    if theory.rotary_inertia:
        rotary = omega2 * rho * second
    EI, mass = E * second, omega2 * rho * A
    reach = (mass / EI) ** mpf(0.25) + mp.sqrt(mass * give) + mp.sqrt(rotary / EI)
    pieces = int(mp.ceil(reach * length / mpf(0.7)))
    h = length / pieces
    # w' = theta + V / kGA, theta' = M / EI, V' = -lambda rhoA w, M' = -V - lambda rhoI theta.
    step = mp.matrix([[0, 1, give, 0], [0, 0, 0, 1 / EI], [-mass, 0, 0, 0], [0, -rotary, -1, 0]])
    T = exponential(step * h)
    a, b, c, d = T[:2, :2], T[:2, 2:], T[2:, :2], T[2:, 2:]
    inverse = b**-1
    piece = mp.zeros(4)
    for i in range(2):
        for j in range(2):
            piece[i, j] = (inverse * a)[i, j]
            piece[i, 2 + j] = -inverse[i, j]
            piece[2 + i, j] = (c - d * inverse * a)[i, j]
            piece[2 + i, 2 + j] = (d * inverse)[i, j]
    K = mp.zeros(2 * pieces + 2)
    for k in range(pieces):
        for i in range(4):
            for j in range(4):
                K[2 * k + i, 2 * k + j] += piece[i, j]
    below, stiffness = 0, []
    tip = 2 * pieces
    for base in ([1], []):
        order = [*base, *range(2, tip), tip + 1, tip]
        some = mp.matrix([[K[i, j] for j in order] for i in order])
        count, driven = negative_pivots(some, len(order) - 1, band=5)
        below += count
        stiffness.append(driven)
    k = mp.sqrt(omega2 * rho / E)
    stiffness.append(E * A * k * mp.cot(k * length))
    below += int(mp.ceil(k * length / mp.pi)) - 1
    twist = mp.sqrt(omega2 * rho / mpf(rod.material.shear)) * length / mp.pi
    return below + max(0, int(mp.ceil(twist - mpf(0.5)))), stiffness


def exponential(X):
    total, term, k = mp.eye(4), mp.eye(4), 0
    # Far beyond the digits asked for: X is small in its own units only.
    while k < 90:
        k += 1
        term = term * X / k
        total += term
    return total


def negative_pivots(matrix, eliminated, band=None):
    """Return how many of the first pivots are negative, and the last entry that they leave."""
    A, size, below = matrix.copy(), matrix.rows, 0
    for k in range(eliminated):
        below += A[k, k] < 0
        last = size if band is None else min(size, k + band)
        for i in range(k + 1, last):
            factor = A[i, k] / A[k, k]
            if factor:
                for j in range(k + 1, last):
                    A[i, j] -= factor * A[k, j]
    return below, A[size - 1, size - 1]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def cross(a, b):
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def check(mechanism, pose, model, count=6, loosest=1e-9):
    """Every bracket holds its mode; return the brackets, or None where they are refused."""
    try:
        bounds = model.brackets(mechanism, pose, count)
    except NotCertifiedError:
        return None
    for k, (low, high) in enumerate(bounds):
        if low > 0:
            assert exact_count(mechanism, pose, model, low) <= k, (k, low)
            assert high / low - 1 <= loosest
        assert exact_count(mechanism, pose, model, high) >= k + 1, (k, high)
    return bounds
