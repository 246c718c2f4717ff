"""What a simulator can be given to take home: input files that need nothing of this bench.

An exporter is behind an entry point of the group `rps_bench.exporters`: a function of mechanism,
pose, elements a limb (None: its own number) and number of modes that returns an `Export`.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import entry_points
from typing import Any, Protocol

import numpy as np

from analytic.errors import InputError
from analytic.mechanism import Mechanism
from analytic.pose import Pose
from reference_models.catalogue import Named
from reference_models.chain_placement import Standing
from reference_models.projection import NOISE, RANK, STILL
from reference_models.units import SLOWNESS

GROUP = "rps_bench.exporters"
SOLVE = f'''

def lowest(M, K, J, count, shift):
    """Return the `count` lowest frequencies [Hz] of the motions that the joints, J q = 0, allow.

    Motions without energy, as of a limb between two balls about itself, are no vibrations. `shift`
    [rad^2/s^2] makes K regular where there are any: (K + shift M) x = (omega^2 + shift) M x.
    """
    size = np.linalg.norm(J, axis=1)
    real = size > {NOISE} * size.max(initial=0.0)
    _, singular, V = np.linalg.svd(J[real] / size[real, None])
    free = V[int((singular > {RANK} * singular[0]).sum()) :].T
    K, M = free.T @ (K + shift * M) @ free, free.T @ M @ free
    L = np.linalg.inv(np.linalg.cholesky((K + K.T) / 2))
    mu = np.linalg.eigvalsh(L @ (M + M.T) / 2 @ L.T)[::-1]
    omega2 = 1 / mu[: count + SPINS] - shift
    return np.sqrt(omega2[omega2 > {STILL}**2 * omega2[-1]])[:count] / (2 * np.pi)
'''
"""What a script of any chain solves by: numpy alone."""


@dataclass(frozen=True)
class Export:
    """`files` by name, the command that `run`s them, and the `model` of the bench that they are."""

    files: Mapping[str, str]
    run: str
    model: Named


class Exporter(Protocol):
    """What is behind the entry point."""

    def __call__(
        self, mechanism: Mechanism, pose: Pose, elements: int | None, count: int
    ) -> Export:
        """Return the files of one mechanism at one pose, in SI units."""
        ...


def exporter(name: str) -> Exporter:
    """Return the exporter called `name`; raises `InputError` with the names there are."""
    found = {point.name: point for point in entry_points(group=GROUP)}
    if name not in found:
        raise InputError("to", name, f"one of {', '.join(sorted(found))}")
    loaded: Any = found[name].load()
    exporter: Exporter = loaded
    return exporter


def about(mechanism: Mechanism, pose: Pose, model: Named) -> Iterator[str]:
    """Yield what every file says at its top."""
    tilt, azimuth, torsion = np.degrees([pose.tilt, pose.azimuth, pose.torsion])
    simple = mechanism.simple
    chains = ["R-P-S"] if simple else dict.fromkeys(limb.described for limb in mechanism.limbs)
    kinds = " and ".join(chains)
    yield f"The parallel manipulator of {len(mechanism.limbs)} {kinds} limbs, actuators locked."
    yield f"Written by rps-bench as its model {model.label}. SI units: m, kg, s, N."
    place = "" if pose.x is None else f"x = {pose.x:g} m, y = {pose.y:g} m, "
    turned = f", torsion {torsion:g} deg" if torsion else ""
    yield f"Pose: {place}z = {pose.z:g} m, azimuth {azimuth:g} deg, tilt {tilt:g} deg{turned}."
    if simple:
        yield "B_i: revolute joint on the base. A_i: spherical joint on the rigid platform."
    else:
        yield "Limbs run from B_i on the base to A_i on the rigid platform."


def shift_of(limbs: Iterable[Standing]) -> float:
    """Return an omega^2 [rad^2/s^2] far below those of waves along limbs: see `SOLVE`.

    No answer depends on it, but for what rounding leaves, and that little over many orders.
    """
    longest = max(
        limb.length
        * max(((r.material.density / r.material.young) ** 0.5 for r in limb.limb.rods),
              default=SLOWNESS)
        for limb in limbs
    )  # fmt: skip
    return (0.02 / longest) ** 2
