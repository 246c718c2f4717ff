"""What was solved while it was timed, as rows for the history."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import Modes
from analytic.theory import Theory
from harness.cases import Case
from harness.models import SOLID_LIMB, Spec
from harness.run import mechanism_hash, mode_rows, settings

Array = NDArray[np.float64]


def first_pose(answer: Any) -> Modes | Array:
    """Return modes, or the frequencies (m,) of the first of many poses, as they are answered."""
    return answer if isinstance(answer, Modes) else np.atleast_2d(answer)[0]


@dataclass(frozen=True)
class Solved:
    """One model at one pose, and what distinguishes how it was solved and timed.

    Attributes: `spec`; `case`, of many poses a call the first; `way`, the name of how it was
    solved; `timed`, the command that says how it was timed, "" if it was not; `poses` of a call
    that takes many; `read`: what makes modes or frequencies of the answer; `version`, where it
    is frequencies alone.
    """

    spec: Spec
    case: Case
    way: str
    timed: str = ""
    poses: int | None = None
    read: Callable[[Any], Modes | Array] = first_pose
    version: str = "rps-bench, condensed"

    def rows(self, answer: Any, seconds: float | None) -> list[dict[str, Any]]:
        """Return a row for every mode of the answer, as of `harness.run.rows`.

        `seconds` a pose were timed as a whole, matrices and all: `build_s` is 0. None where the
        time is not known.
        """
        found = self.read(answer)
        frequencies = found.frequencies if isinstance(found, Modes) else found
        how = {"way": self.way, "timed": self.timed, "poses": self.poses}
        known = {name: value for name, value in how.items() if value}
        chosen = settings(self.spec, len(frequencies), **known)
        if isinstance(found, Modes):
            rows = mode_rows(self.case, self.spec, chosen, found, len(frequencies))
        else:
            rows = self._frequency_rows(frequencies, chosen)
        built = None if seconds is None else 0.0
        return [row | {"build_s": built, "solve_s": seconds} for row in rows]

    def _frequency_rows(self, frequencies: Array, chosen: str) -> list[dict[str, Any]]:
        theory, version = self._origin()
        common = {
            "case": self.case.name,
            "mechanism": mechanism_hash(self.case.mechanism),
            "z_m": self.case.pose.z,
            "azimuth_rad": self.case.pose.azimuth,
            "tilt_rad": self.case.pose.tilt,
            "model": self.spec.label,
            "theory": theory,
            "settings": chosen,
            "version": version,
        }
        return [
            common | {"mode": mode, "frequency_hz": value}
            for mode, value in enumerate(frequencies.tolist(), 1)
        ]

    def _origin(self) -> tuple[str, str]:
        """Return theory and version of frequencies without modes."""
        if self.spec.name == SOLID_LIMB:
            limb: Any = self.spec.build()
            return limb.theory, limb.version
        theory = Theory(self.spec.name, self.spec.shear)
        return theory.labels(self.case.mechanism), self.version
