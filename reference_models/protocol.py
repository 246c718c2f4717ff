"""What simulators share: how they say that they cannot run, or that an answer is not one."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class UnavailableError(RuntimeError):
    """A model that cannot run here, with the reason."""


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
