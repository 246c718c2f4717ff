"""How fast the machine is during a run: an eigen-solution of known answer, timed beside it."""

import time
from collections.abc import Sequence
from statistics import median
from typing import Any

import numpy as np

YARDSTICK, REPEATS = "yardstick", 15
"""The model and case of the row that says how fast the machine was."""


def yardstick(masses: int = 150) -> tuple[float, float]:
    """Return the lowest frequency [Hz] of a chain and the median time of its eigen-solution [s].

    Unit masses and springs in a row between walls: omega_k = 2 sin(k pi / 2 (masses + 1)).
    """
    K, seconds = 2 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1), []
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
