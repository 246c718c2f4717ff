"""Limbs of any chain without elements: the frequency-dependent problem, and its modes counted.

Every rod is cut until no piece has a mode with both ends held below the frequencies asked for
(`rod_exact.pieces`). Then D(omega^2) over the independent coordinates of `network` has no pole
there, and by Wittrick and Williams (1971) as many modes lie below omega as D has negative
eigenvalues. Motions of a limb's own that need no energy (see `mobility.spins`) count once each at
any omega; they are left out.

D is written in the motions of the mechanism's elements, one a piece, each divided by the larger of
its own omega and the one asked for, so that every entry is of order one, and then by the root of
that ratio: rounding of stiff motions, far from zero, is not to blur soft ones.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from analytic.certified import CLOSE, certified, roots
from analytic.errors import NotCertifiedError
from analytic.mechanism import Mechanism, Rod
from analytic.mobility import check_held, spins
from analytic.modes import check_count
from analytic.network import Network, network
from analytic.placed import Placed, place, position
from analytic.pose import Pose
from analytic.rod_elements import Properties, element_matrices, properties
from analytic.rod_exact import dynamic_stiffness, pieces
from analytic.theory import Theory
from analytic.wittrick_williams import Counted

Floats = NDArray[np.float64]

STEP = 1e-30
UNLIKE = "modes of masses so unlike that the lighter ones are rounding"
ROUNDING = 4 * float(np.finfo(float).eps)
"""Relative error of one entry of D; the bound on its eigenvalues is made of it."""
ABOVE = 1e-6
"""Rounding of the elements' bounds, relative."""
MARGIN = 1.0 + 1e-6
"""Frequencies up to this factor above those asked for can be counted without another cut."""


@dataclass(frozen=True)
class ChainForm(Counted):
    """D at omega^2 of q values in scaled motions: what `certified` asks of a `Form`.

    Attributes: `omega2` (q,); `matrix` (q, m, m) and `mass` = -dD/d(omega^2); `outside`, minus the
    number of spins (q,); `error`, a bound on the rounding of D's eigenvalues (q,); `back` turns
    motions into coordinates (q, m, m).
    """

    omega2: Floats
    matrix: Floats
    mass: Floats
    outside: NDArray[np.int64]
    error: Floats
    back: Floats

    @cached_property
    def pencil(self) -> tuple[Floats, Floats]:
        """(matrix, left) of D x = delta (-D') x made standard; delta are steps to the modes.

        Raises `NotCertifiedError` where rounding leaves no mass.
        """
        try:
            left = np.linalg.inv(np.linalg.cholesky(self.mass))
        except np.linalg.LinAlgError:
            raise NotCertifiedError(UNLIKE) from None
        return left @ self.matrix @ left.swapaxes(1, 2), left


@dataclass(frozen=True)
class Exact:
    """The frequency-dependent problem of one mechanism at one pose.

    Attributes: `groups` of limbs; `of` the properties of every rod of theirs, by (group, item);
    `platform_mass` M_p (6, 6) in global axes; `unit` a length [m]; `spins` how many motions of
    limbs need no energy.
    """

    groups: tuple[Placed, ...]
    of: dict[tuple[int, int], Properties]
    platform_mass: Floats
    unit: float
    spins: int

    def lengths(self, group: int, item: int) -> Floats:
        """Return the lengths of a rod of n limbs, (n,) [m]."""
        return np.asarray(self.groups[group].lengths[:, item])

    def cut(self, omega2: float) -> Network:
        """Return the network whose rods have no mode with ends held below `omega2`."""

        def count(group: int, item: int) -> int:
            return pieces(self.of[group, item], self.lengths(group, item), omega2)

        return network(self.groups, count, self.platform_mass, self.unit)

    def split(self, elements: int) -> Network:
        """Return the network with so many pieces a rod."""
        return network(self.groups, lambda *_: elements, self.platform_mass, self.unit)

    def pair(self, net: Network, *, sparse: bool = False) -> tuple[Floats, Floats]:
        """Return K and M of elements, one a piece of `net`: Eq. (22)."""
        each = [
            element_matrices(self.of[p.group, p.item], self.lengths(p.group, p.item) / p.count)
            for p in net.rods
        ]
        blocks = net.rod_blocks(each) + [block for _, _, block in net.constant]
        K, M = net.layout(sparse=sparse).pair(blocks)
        return K, M

    def dynamic(self, net: Network, omega2: NDArray[Any]) -> NDArray[Any]:
        """Return D of `net` at `omega2` (q,), (q, m, m); complex of complex."""
        each = [
            dynamic_stiffness(
                self.of[p.group, p.item], self.lengths(p.group, p.item) / p.count, omega2
            )
            for p in net.rods
        ]
        q = len(omega2)
        blocks = net.rod_blocks(each)
        blocks += [
            block[0] - omega2[:, None, None, None] * block[1] for _, _, block in net.constant
        ]
        where = net.layout()
        entries = np.concatenate([block.reshape(q, -1) for block in blocks], axis=1)
        result = np.zeros((q, net.size**2), dtype=entries.dtype)
        for i in range(q):
            of = entries[i][where.taken]
            result[i] = np.bincount(where.slots, of.real, net.size**2)
            if np.iscomplexobj(of):
                result[i] += 1j * np.bincount(where.slots, of.imag, net.size**2)
        return result.reshape(q, net.size, net.size)

    @cached_property
    def _motions(self) -> dict[tuple[int, ...], tuple[Floats, Floats]]:
        return {}

    def motions(self, net: Network) -> tuple[Floats, Floats]:
        """Return sigma (m,) [1/s] and vectors (m, m) of the elements' modes."""
        key = tuple(p.count for p in net.rods)
        if key not in self._motions:
            K, M = self.pair(net)
            values, vectors = scipy.linalg.eigh(K, M)
            values[: self.spins] = 0.0
            self._motions[key] = np.sqrt(np.maximum(values, 0.0)), vectors
        return self._motions[key]

    @cached_property
    def static(self) -> tuple[Floats]:
        """(sigma,) of one element a rod, falling, spins last: as of `Characteristic`."""
        return (self.motions(self.split(1))[0][::-1],)

    @property
    def first(self) -> float:
        """About omega^2 of the softest rod's first mode between pins."""
        found = [
            ((np.pi / self.lengths(*key)) ** 4 * of.EI.min(axis=1) / of.mass).min()
            for key, of in self.of.items()
        ]
        if not found:  # no rods: of the platform on its springs
            return float(self.motions(self.split(1))[0][0] ** 2)
        return float(min(found))

    def form(self, omega2: Floats) -> ChainForm:
        """Return D and its derivative at each of `omega2` (q,) > 0."""
        return self._form(self.cut(float(omega2.max()) * MARGIN), omega2)

    def _form(self, net: Network, omega2: Floats) -> ChainForm:
        sigma, vectors = self.motions(net)
        D = self.dynamic(net, omega2 * (1 + 1j * STEP))
        omega = np.sqrt(omega2)[:, None]
        larger = np.maximum(sigma, omega)
        scale = np.sqrt(omega / larger) / larger
        back = vectors * scale[:, None, :]
        real = np.ascontiguousarray(D.real)
        matrix = back.swapaxes(1, 2) @ real @ back
        slope = D.imag / (STEP * omega2[:, None, None])
        mass = -(back.swapaxes(1, 2) @ slope @ back)
        size = np.abs(back)
        error = ROUNDING * (size.swapaxes(1, 2) @ np.abs(real) @ size).sum(axis=2).max(axis=1)
        outside = np.full(len(omega2), -self.spins)
        symmetric = (matrix + matrix.swapaxes(1, 2)) / 2, (mass + mass.swapaxes(1, 2)) / 2
        return ChainForm(omega2, *symmetric, outside, error, back)

    def brackets(self, count: int) -> Floats:
        """Return brackets of the lowest `count` omega^2, spins apart, (count, 2).

        Elements interpolate what a rod may do: their frequencies are bounds from above, which first
        say how to cut and then where to look. Each mode is found by its rank, and both ends of its
        bracket are counted. Raises `NotCertifiedError` where rounding leaves one too wide.
        """
        upper = self.upper(count)
        upper = self.upper(count, self.cut(float(upper[-1])))
        if not upper[0] > 0:
            raise NotCertifiedError(UNLIKE)
        rank = np.arange(count)
        high = upper * (1 + ABOVE)
        for close in CLOSE:
            x = roots(self, rank, np.zeros(count), high, upper, close)
            try:
                return certified(self, rank, self._polished(rank, x))
            except NotCertifiedError:
                if close == CLOSE[-1]:
                    raise
        raise AssertionError

    def _polished(self, rank: NDArray[np.intp], omega2: Floats) -> Floats:
        """Return roots by D's own eigenvalues, whose rounding no stiff motion makes large."""
        x = omega2
        for _ in range(2):
            form = self.form(x)
            values, vectors = np.linalg.eigh(form.matrix)
            row, k = np.arange(len(x)), rank + self.spins
            v = vectors[row, :, k]
            x = x + values[row, k] / np.einsum("qi,qij,qj->q", v, form.mass, v)
        return x

    def upper(self, count: int, net: Network | None = None) -> Floats:
        """Return upper bounds of the lowest `count` omega^2, from as many elements as it takes."""
        s = 1
        net = net or self.split(s)
        if not net.rods:
            check_count(count, net.size)
        while net.size - self.spins < count:
            s *= 2
            net = self.split(s)
        sigma = self.motions(net)[0]
        return np.asarray(sigma[self.spins : self.spins + count] ** 2)

    def count(self, omega2: Floats) -> NDArray[np.int64]:
        """Return the number of modes below each of `omega2` (q,)."""
        return self.form(omega2).count

    def eigenspace(self, net: Network, omega2: float, size: int) -> Floats:
        """Return the `size` modes next to `omega2`, of modal mass 1, in `net` (m, size).

        `net` must be cut for `omega2` at least.
        """
        form = self._form(net, np.array([omega2]))
        B, left = form.pencil
        values, y = np.linalg.eigh(B[0])
        near = np.argsort(np.abs(values))[:size]
        return np.asarray(form.back[0] @ left[0].T @ y[:, near])


def exact(mechanism: Mechanism, pose: Pose, theory: Theory) -> Exact:
    """Return the problem at one pose.

    Raises `InputError` for a pose out of reach, or a mechanism that can move with its drives
    locked.
    """
    groups = place(mechanism, pose)
    o = position(mechanism, pose)
    unit = float(np.mean([group.lengths.sum(axis=-1).mean() for group in groups]))
    check_held(groups, o, unit)
    turn = np.kron(np.eye(2), pose.rotation)
    of = {
        (g, k): properties(_rods(group, k), theory)
        for g, group in enumerate(groups)
        for k in group.alike.rods
    }
    mass = turn @ mechanism.platform.mass_matrix @ turn.T
    # Limbs without rods weigh nothing: their own motions are none.
    spinning = spins([group for group in groups if group.alike.rods], o, unit)
    return Exact(tuple(groups), of, mass, unit, spinning)


def _rods(group: Placed, item: int) -> list[Rod]:
    return [chain[item] for chain in group.alike.chains]  # type: ignore[misc]
