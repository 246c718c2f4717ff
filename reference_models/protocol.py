"""The one call every reference model answers, and how models are found.

A reference model is a class behind an entry point of the group `rps_bench.reference_models`. Any
installed package can add one.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Protocol, runtime_checkable

from analytic.errors import InputError
from analytic.mechanism import Mechanism
from analytic.modes import Modes
from analytic.pose import CLOSURE, Pose
from reference_models.richardson import Richardson

GROUP = "rps_bench.reference_models"


@dataclass(frozen=True)
class Info:
    """What is known of a model before it runs.

    Attributes: `theory` of its rods, in words; `program` and `version` it runs on; formal `order`
    of convergence of its frequencies in the elements; `refinements`: the two numbers of elements
    to extrapolate from when none is asked for; a `remark` its users must know; `missing`: why it
    cannot run here and what to do about it, empty if it can; `torsion`: whether its rods twist.
    Torsion of a limb between a revolute and a spherical joint is coupled to nothing: a model whose
    rods do not twist lacks these modes and has all others.
    """

    theory: str
    program: str
    version: str
    order: float
    refinements: tuple[int, int] = (8, 16)
    remark: str = ""
    missing: str = ""
    torsion: bool = True


@runtime_checkable
class ReferenceModel(Protocol):
    """One simulator with one way to model the rods; `elements` a limb."""

    elements: int

    @classmethod
    def info(cls) -> Info:
        """Return what the model is, without running it or raising if it is missing."""
        ...

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose."""
        ...


class UnavailableError(RuntimeError):
    """A model that cannot run here, with the reason."""


class ModelError(RuntimeError):
    """A simulator that ran and failed, or whose answer must not be believed."""


def names() -> list[str]:
    """Return the names of all reference models, available or not."""
    return sorted(point.name for point in _points(tuple(sys.path)))


def find(name: str) -> type[ReferenceModel]:
    """Return the class behind `name`, or raise `InputError` with the names there are."""
    for point in _points(tuple(sys.path)):
        if point.name == name:
            found: type[ReferenceModel] = point.load()
            return found
    raise InputError("reference", name, f"one of {', '.join(names())}")


@lru_cache(maxsize=4)
def _points(path: tuple[str, ...]) -> tuple[EntryPoint, ...]:
    """Read once for a `sys.path`: milliseconds, hundreds of times a run."""
    return tuple(entry_points(group=GROUP))


def catalogue() -> Iterator[tuple[str, Info]]:
    """Yield every reference model's name and what is known of it."""
    for name in names():
        try:
            yield name, find(name).info()
        except ImportError as error:
            yield name, Info("", "", "", 0, missing=str(error))


def reference(
    name: str, elements: int | tuple[int, int] | None = None, **settings: Any
) -> "ReferenceModel | Richardson":
    """Return the reference model `name`.

    `elements` is a number a limb, two numbers for Richardson extrapolation from both, or None for
    the model's own default. `settings` go to the model. Raises `InputError` for an unknown name or
    setting and `UnavailableError` where its program is missing.
    """
    model = find(name)
    info = model.info()
    if info.missing:
        raise UnavailableError(f"reference model {name!r} cannot run here: {info.missing}")
    try:
        if elements is None:
            return model(**settings)
        if isinstance(elements, tuple):
            coarse, fine = (model(elements=n, **settings) for n in elements)  # type: ignore[call-arg]
            return Richardson(coarse, fine, info.order)
        return model(elements=elements, **settings)  # type: ignore[call-arg]
    except TypeError as error:
        raise InputError("settings", settings, f"settings of {name!r} ({error})") from None


def check_closure(model: str, residual: float) -> float:
    """Return `residual` [m] if the joints are closed to 1e-9 m, or raise `ModelError`."""
    if not residual <= CLOSURE:
        raise ModelError(
            f"{model}: joints are open by {residual:.1e} m, more than {CLOSURE:.0e} m; "
            "its frequencies are not those of the closed mechanism"
        )
    return residual
