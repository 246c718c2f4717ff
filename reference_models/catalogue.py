"""All models by name: analytic ones and simulators, this bench's and anybody's.

A model is behind an entry point of the group `rps_bench.reference_models`: a class, or anything
that is called with `elements` and settings, with `info()` beside it. Any installed package can add
one.
"""

import inspect
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError, unknown
from analytic.mechanism import Mechanism
from analytic.model import Info
from analytic.modes import Modes
from analytic.pose import Pose
from reference_models.described import senseless
from reference_models.protocol import UnavailableError
from reference_models.richardson import Richardson

GROUP = "rps_bench.reference_models"
OWN = ("analytic", "reference_models")
"""Packages of this bench's own models."""
EXACT = "exact"
Elements = int | tuple[int, int] | None
_LABEL = re.compile(r"(?P<name>[^@\[\]]+)(@(?P<elements>[^@\[\]]+))?(\[(?P<settings>[^\[\]]*)\])?")


@dataclass(frozen=True)
class Named:
    """A model of the catalogue: its name, its elements a limb, and settings unlike its defaults.

    `elements` is a number, two for Richardson extrapolation from both, or None for the exact model.
    Two that differ in anything are two models. Nothing is looked up before it is asked for.
    """

    name: str
    elements: Elements
    settings: tuple[tuple[str, Any], ...] = ()

    @property
    def label(self) -> str:
        """What `parse` reads back: NAME@3, NAME@8+16, NAME@exact, settings in brackets."""
        match self.elements:
            case None:
                number = EXACT
            case (coarse, fine):
                number = f"{coarse}+{fine}"
            case _:
                number = str(self.elements)
        own = ",".join(f"{key}={value}" for key, value in self.settings)
        return f"{self.name}@{number}[{own}]" if own else f"{self.name}@{number}"

    @property
    def owner(self) -> str:
        """The package that it is from, "" of the bench's own: others may run beside them only."""
        package = known(self.name, "model").module.partition(".")[0]
        return "" if package in OWN else package

    def info(self) -> Info:
        """Return what the model is, without running it; never raises."""
        return _info(self)

    def build(self) -> Any:
        """Return the model behind the name.

        Raises `InputError` for unknown names, settings or elements, and `UnavailableError` where
        its program is missing or it cannot be built.
        """
        missing = self.info().missing
        if missing:
            raise UnavailableError(f"model {self.name!r} cannot run here: {missing}")
        return _built(self)

    def given(self, **settings: Any) -> "Named":
        """Return this model with those of `settings` that it has."""
        mine = accepted(self.name)
        own = {key: value for key, value in settings.items() if key in mine}
        return replace(self, settings=tuple(sorted({**own, **dict(self.settings)}.items())))

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose; raises whatever the model raises."""
        found: Modes = self.build().modes(mechanism, pose, count)
        return found

    def frequencies(self, mechanism: Mechanism, poses: Pose, count: int = 6) -> NDArray[np.float64]:
        """Return the `count` lowest frequencies at every pose, (len(poses), count) [Hz]."""
        model = self.build()
        if hasattr(model, "frequencies"):
            return np.asarray(model.frequencies(mechanism, poses, count))
        return np.array([model.modes(mechanism, pose, count).frequencies for pose in poses])

    def limit(self) -> "Named | None":
        """Return the exact model of the theory that this one declares, or None."""
        name = self.info().limit
        if not name:
            return None
        return _exact(name, self.settings)


def names() -> list[str]:
    """Return the names of all models, available or not."""
    return sorted(_points(tuple(sys.path)))


def catalogue() -> Iterator[tuple[str, Info]]:
    """Yield every model's name and what is known of it."""
    for name in names():
        yield name, Named(name, None).info()


def reference(name: str, elements: Any = ..., **settings: Any) -> Named:
    """Return the model `name`.

    `elements` is a number a limb, two numbers for Richardson extrapolation from both, None for the
    exact model, or left out for the model's own default. Raises `InputError` for an unknown name,
    setting or number of elements, and `UnavailableError` where its program is missing.
    """
    known(name, "reference")
    if missing := Named(name, None).info().missing:
        raise UnavailableError(f"model {name!r} cannot run here: {missing}")
    if elements is ...:
        elements = inspect.signature(find(name)).parameters["elements"].default
    model = Named(name, elements, tuple(sorted(settings.items())))
    model.build()
    return model


def parse(text: str, argument: str, **settings: Any) -> Named:
    """Return the model that `text` names: NAME, NAME@3, NAME@8+16 or NAME@exact, each also with
    [SETTING=VALUE,...] behind it. This reads back every label.

    A bare name means three elements for a theory (the paper's number), and a simulator's own two
    refinements, extrapolated. `settings` are given to a model that has them. Raises `InputError`
    naming the `argument`.
    """
    found = _LABEL.fullmatch(text.strip())
    if found is None:
        raise InputError(argument, text, "NAME, NAME@ELEMENTS or NAME@exact")
    name, number, own = found["name"], found["elements"], found["settings"]
    known(name, argument)
    info, mine = Named(name, None).info(), accepted(name)
    given: dict[str, Any] = {}
    for item in own.split(",") if own else ():
        key, _, value = item.partition("=")
        if not info.missing and key.strip() not in mine:
            expected = f"settings of {name}: {', '.join(sorted(mine)) or 'it has none'}"
            raise InputError(argument, text, expected)
        given[key.strip()] = _value(value.strip())
    size = _elements(name, info, number, argument, text)
    model = Named(name, size, tuple(sorted(given.items()))).given(**settings)
    if not info.missing and (number or own or settings):  # its own defaults are its own fault
        try:
            model.build()
        except InputError as error:
            raise InputError(
                argument, text, f"elements and settings that {name} has ({error})"
            ) from None
        except UnavailableError:  # said when it is asked: the others can answer
            return model
    return model


def _elements(name: str, info: Info, number: str | None, argument: str, text: str) -> Elements:
    """Return the elements of a label, or raise `InputError`."""
    single = info.refinements is None
    if number is None:
        if info.refinements is not None:
            return info.refinements
        default: Elements = inspect.signature(find(name)).parameters["elements"].default
        return default
    if number == EXACT and single:
        return None
    sizes = [int(part) if part.isdecimal() and len(part) < 10 else 0 for part in number.split("+")]
    if len(sizes) == 1 and sizes[0] > 0:
        return sizes[0]
    if len(sizes) == 2 and not single and 0 < sizes[0] < sizes[1]:
        return sizes[0], sizes[1]
    forms = "NAME@3 or NAME@exact" if single else "NAME@16, or NAME@8+16 to extrapolate"
    raise InputError(argument, text, f"elements as in {forms}")


def _value(text: str) -> int | float | str | bool | None:
    """Return what a setting's text means."""
    words = {"True": True, "False": False, "None": None}
    if text in words:
        return words[text]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def find(name: str, argument: str = "model") -> Any:
    """Return what is behind `name`; raises as `known`, and whatever loading raises."""
    return known(name, argument).load()


def known(name: str, argument: str) -> EntryPoint:
    """Return where `name` is, or raise `InputError` with the names there are."""
    points = _points(tuple(sys.path))
    if name not in points:
        raise unknown(argument, name, sorted(points))
    return points[name]


@lru_cache(maxsize=4)
def _points(path: tuple[str, ...]) -> dict[str, EntryPoint]:
    """Read once for a `sys.path`: milliseconds, hundreds of times a run."""
    return {point.name: point for point in entry_points(group=GROUP)}


def accepted(name: str) -> frozenset[str]:
    """Return the names of the settings that a model has besides its elements; none if unknown."""
    try:
        thing = find(name)
        own = getattr(thing, "settings", None)
        names = own if own is not None else inspect.signature(thing).parameters
    except Exception:  # a plug-in that cannot be imported has none
        return frozenset()
    return frozenset(names) - {"elements"}


def _info(named: Named) -> Info:
    try:
        thing = find(named.name)
    except InputError:
        raise
    except BaseException as error:
        return _unusable(f"it cannot be imported ({type(error).__name__}: {error})")
    try:
        if "elements" not in inspect.signature(thing).parameters:
            return _unusable("it takes no elements")
        said = thing.info()
    except BaseException as error:
        return _unusable(f"its info() raises {type(error).__name__}: {error}")
    if why := senseless(said, names()):
        return _unusable(f"its info() {why}")
    info: Info = said
    if named.settings and not info.missing:
        try:
            own = _one(named, _coarser(named)).info()
        except Exception:  # settings that it does not have: said when it is built
            return info
        info = own if isinstance(own, Info) else info
    given = dict(named.settings)
    if info.isolated and info.limit and given.keys() & {"beam", "shear"}:
        # A simulator's info is of its class, not of this one.
        exact = _exact(given.get("beam", info.limit), named.settings)
        info = replace(info, limit=exact.name, theory=exact.info().theory)
    return info


def _exact(name: str, settings: tuple[tuple[str, Any], ...]) -> Named:
    """Return the exact model `name`, of the same shear coefficient if it has one."""
    shear = tuple(pair for pair in settings if pair[0] == "shear")
    return Named(name, None, shear if "shear" in accepted(name) else ())


def _coarser(named: Named) -> Elements:
    """Return the elements of one mesh of a model: the coarser of two."""
    return named.elements[0] if isinstance(named.elements, tuple) else named.elements


def _unusable(why: str) -> Info:
    return Info("unknown", "", "", 0, missing=why)


@lru_cache(maxsize=256)
def _built(named: Named) -> Any:
    info = named.info()
    if isinstance(named.elements, tuple):
        if info.refinements is None:
            raise InputError("elements", named.elements, "one number for this model")
        coarse, fine = (_one(named, n) for n in named.elements)
        return Richardson(coarse, fine, info.order)
    return _one(named, named.elements)


def _one(named: Named, elements: Elements) -> Any:
    thing = find(named.name)
    if elements is None and thing.info().isolated:
        raise InputError("elements", None, f"a number of elements for {named.name}")
    given = dict(named.settings)
    try:
        inspect.signature(thing).bind(elements=elements, **given)
    except TypeError as error:
        raise InputError("settings", given, f"settings of {named.name} ({error})") from None
    try:
        return thing(elements=elements, **given)
    except (InputError, UnavailableError):
        raise
    except Exception as error:
        why = f"it cannot be built ({type(error).__name__}: {error})"
        raise UnavailableError(f"model {named.name!r} cannot run here: {why}") from None
