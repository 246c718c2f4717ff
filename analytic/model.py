"""The one protocol that every model of the bench answers, analytic or simulated."""

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from numpy.typing import NDArray

from analytic.mechanism import Mechanism
from analytic.modes import Modes
from analytic.pose import Pose


@dataclass(frozen=True)
class Info:
    """What is known of a model before it runs.

    Attributes:
        theory: of its rods, in words; models of equal theory converge to the same numbers.
        program, version: what it runs on.
        order: at which its frequencies converge in the elements.
        refinements: two numbers of elements to extrapolate from when none is asked for; None for a
            model that is not extrapolated by default.
        ladder: ascending elements on which its convergence is watched.
        limit: the catalogue's name of the exact model of its theory, "" where there is none.
        relaxed, assumption: the model that is this one without one assumption, and that
            assumption's name; "" where there is none.
        remark: what its users must know.
        missing: why it cannot run here and what to do about it; "" if it can.
        torsion: whether its rods twist. Torsion of a limb between a revolute and a spherical joint
            is coupled to nothing: a model without it lacks these modes and has all others.
        slow: whether a pose takes about a second or more.
        isolated: whether it must run in a process of its own, since it may crash or hang.
        precision: how far, relative, two answers to one problem in other words may lie apart:
            rounding, difference steps and printed digits.
    """

    theory: str
    program: str
    version: str
    order: float
    refinements: tuple[int, int] | None = (8, 16)
    ladder: tuple[int, ...] = (4, 8, 16)
    limit: str = ""
    relaxed: str = ""
    assumption: str = ""
    remark: str = ""
    missing: str = ""
    torsion: bool = True
    slow: bool = False
    isolated: bool = True
    precision: float = 1e-9


@runtime_checkable
class Model(Protocol):
    """What analytic models and simulators have in common; hashable, equal by what they compute."""

    @property
    def elements(self) -> int | tuple[int, int] | None:
        """Elements a limb; two where extrapolated; None without elements."""
        ...

    def info(self) -> Info:
        """Return what the model is, without running it; never raises."""
        ...

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose."""
        ...

    def frequencies(self, mechanism: Mechanism, poses: Pose, count: int = 6) -> NDArray[Any]:
        """Return the `count` lowest frequencies at many poses, shape (len(poses), count) [Hz]."""
        ...

    def limit(self) -> "Model | None":
        """Return the exact model of the theory that this one declares, or None."""
        ...
