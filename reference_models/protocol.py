"""What simulators share: how they say that they cannot run, or that an answer is not one."""

from analytic.pose import CLOSURE


class UnavailableError(RuntimeError):
    """A model that cannot run here, with the reason."""


class ModelError(RuntimeError):
    """A simulator that ran and failed, or whose answer must not be believed."""


def check_closure(model: str, residual: float) -> float:
    """Return `residual` [m] if the joints are closed to 1e-9 m, or raise `ModelError`."""
    if not residual <= CLOSURE:
        raise ModelError(
            f"{model}: joints are open by {residual:.1e} m, more than {CLOSURE:.0e} m; "
            "its frequencies are not those of the closed mechanism"
        )
    return residual
