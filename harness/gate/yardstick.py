"""How fast the machine is during a run: an eigen-solution of known answer, timed beside it."""

import time
from collections.abc import Sequence
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray

YARDSTICK, REPEATS = "yardstick", 15
"""The model and case of the row that says how fast the machine was."""


def yardstick_matrix(masses: int = 150) -> NDArray[np.float64]:
    """Return K of unit masses in a row between walls, unit springs between, (masses, masses).

    omega_k = 2 sin(k pi / 2 (masses + 1)).
    """
    return np.asarray(2 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1))


def yardstick() -> tuple[float, float]:
    """Return the chain's lowest frequency [Hz] and the median time of its eigen-solution [s]."""
    K, seconds = yardstick_matrix(), []
    for _ in range(REPEATS):
        began = time.perf_counter()
        values = np.linalg.eigh(K)[0]
        seconds.append(time.perf_counter() - began)
    return float(np.sqrt(values[0]) / (2 * np.pi)), median(seconds)


def yardstick_row(measured: Sequence[tuple[float, float]]) -> dict[str, Any]:
    """Return the row of the history for what `yardstick` gave during a run."""
    return {
        "case": YARDSTICK,
        "model": YARDSTICK,
        "theory": "springs and masses in a row",
        "version": f"numpy {np.__version__}",
        "mode": 1,
        "frequency_hz": measured[0][0],
        "build_s": 0.0,
        "solve_s": median(seconds for _, seconds in measured),
    }
