"""What a simulator can be given to take home: input files that need nothing of this bench.

An exporter is behind an entry point of the group `rps_bench.exporters`: a function of mechanism,
pose, elements a limb (None: its own number) and number of modes that returns an `Export`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.metadata import entry_points
from typing import Any, Protocol

import numpy as np

from analytic.errors import InputError
from analytic.mechanism import Mechanism
from analytic.pose import Pose
from reference_models.catalogue import Named

GROUP = "rps_bench.exporters"


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
    tilt, azimuth = np.degrees([pose.tilt, pose.azimuth])
    yield f"The parallel manipulator of {len(mechanism.limbs)} R-P-S limbs, actuators locked."
    yield f"Written by rps-bench as its model {model.label}. SI units: m, kg, s, N."
    yield f"Pose: z = {pose.z:g} m, azimuth {azimuth:g} deg, tilt {tilt:g} deg."
    yield "B_i: revolute joint on the base. A_i: spherical joint on the rigid platform."
