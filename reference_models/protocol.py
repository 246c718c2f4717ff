"""What simulators share: how they say that they cannot run, or that an answer is not one."""

import re

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class UnavailableError(RuntimeError):
    """A model that cannot run here, with the reason."""


def unlinked(program: str, error: ImportError, remedy: str) -> UnavailableError:
    """Return what to raise where `program` is installed and its import ends with `error`.

    It says in one line which library of the system is missing, and then the `remedy`.
    """
    lacking = re.search(r"[^\s/]+\.so[.\d]*(?=: cannot open)", str(error))
    why = f"{lacking[0]} is missing; {remedy}" if lacking else " ".join(str(error).split())
    return UnavailableError(f"{program} cannot be imported: {why}")


class ModelError(RuntimeError):
    """A simulator that ran and failed, or whose answer must not be believed."""


def hertz(model: str, eigenvalues: Array, noise: Array | float) -> Array:
    """Return frequencies [Hz] of `eigenvalues` omega^2, which are known to +-`noise`.

    What is that close to zero is a free motion, of 0 Hz. Raises `ModelError` for what is below.
    """
    below = np.asarray(eigenvalues)[~(eigenvalues >= -np.asarray(noise))]
    if below.size:
        raise ModelError(
            f"{model}: the square of a frequency is {below[0] / (2 * np.pi) ** 2:.2e}, below zero "
            "by more than rounding"
        )
    return np.sqrt(np.where(eigenvalues <= noise, 0.0, eigenvalues)) / (2 * np.pi)
