"""`mujoco-composite`: MuJoCo 3's elastic cable, beside the flex that took its place."""

from dataclasses import dataclass, replace

from analytic.errors import count as whole
from analytic.mechanism import Mechanism
from analytic.model import Info
from analytic.modes import Modes
from analytic.pose import Pose
from reference_models.mujoco import composite, environment

NAME = "mujoco-composite"


@dataclass(frozen=True)
class MujocoComposite:
    """`mujoco-cable` as it is on MuJoCo 3.17.0, in a process and an environment of its own.

    Raises `InputError` for fewer than three elements.
    """

    elements: int = 16

    def __post_init__(self) -> None:
        whole("elements", self.elements, at_least=3)

    @classmethod
    def info(cls) -> Info:
        """Return what the model is; never raises."""
        there = environment.python() is not None
        return Info(
            composite.THEORY,
            "MuJoCo",
            environment.VERSION if there else "",
            composite.ORDER,
            composite.REFINEMENTS,
            (8, 16, 32),
            remark=composite.REMARK,
            missing=""
            if there
            else f"MuJoCo {environment.VERSION} needs an environment of its "
            "own; python -m reference_models.mujoco.environment makes it",
            torsion=composite.TORSION,
        )

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose; raises as `mujoco-cable` and
        `environment.ask`.
        """
        found: Modes = environment.ask((self.elements, mechanism, pose, count))
        return replace(found, model=NAME)
