"""All models by name: analytic ones and simulators, this bench's and anybody's.

A model is behind an entry point of the group `rps_bench.reference_models`: a class, or anything
that is called with `elements` and settings, with `info()` beside it. Any installed package can add
one. What is not of this bench is asked where `ask` says.
"""

import inspect
import re
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError, unknown
from analytic.mechanism import Mechanism
from analytic.model import Info
from analytic.modes import Modes
from analytic.pose import Pose
from reference_models.described import Declaration, plain, senseless
from reference_models.protocol import UnavailableError
from reference_models.richardson import Richardson

GROUP = "rps_bench.reference_models"
OWN = ("analytic", "reference_models")
"""Packages of this bench's own models."""
EXACT = "exact"
LONG = 1000
"""Letters of an error that are passed on."""
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
        return _declared(self).info

    def build(self) -> Any:
        """Return the model behind the name, loaded in this process.

        Raises `InputError` for unknown names, settings or elements, and `UnavailableError` where
        its program is missing or it cannot be built.
        """
        missing = declare(self).info.missing
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
        elements = _declared(Named(name, None)).elements
    model = Named(name, elements, tuple(sorted(settings.items())))
    if not model.owner:
        model.build()
    elif why := asked(misfit, model):
        raise InputError("model", model.label, f"elements and settings that {name} has ({why})")
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
            why = asked(misfit, model)
        except UnavailableError:  # said when it is asked: the others can answer
            return model
        if why:
            raise InputError(argument, text, f"elements and settings that {name} has ({why})")
    return model


def _elements(name: str, info: Info, number: str | None, argument: str, text: str) -> Elements:
    """Return the elements of a label, or raise `InputError`."""
    single = info.refinements is None
    if number is None:
        return info.refinements or _declared(Named(name, None)).elements
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
    if name not in _points(tuple(sys.path)):
        return frozenset()
    named = Named(name, None)
    return _declared(named).settings if named.owner else _settings(_found(named))


Elsewhere = Callable[[Callable[[Named], Any], Named], Any]
_elsewhere: Elsewhere | None = None


def ask(elsewhere: Elsewhere | None) -> None:
    """Ask models of other packages by `elsewhere`; None: in this process, as before any call.

    It calls a function of a model in a process of the model's owner, or raises `UnavailableError`.
    """
    global _elsewhere
    _elsewhere = elsewhere


def asked(what: Callable[[Named], Any], named: Named) -> Any:
    """Return `what(named)`, found where the model may be loaded."""
    return _elsewhere(what, named) if _elsewhere is not None and named.owner else what(named)


def _declared(named: Named) -> Declaration:
    """Return what a model says of itself; never raises but for a name that is unknown."""
    known(named.name, "model")
    # Without settings it is what its class says, whatever its elements.
    mesh = _coarser(named) if named.settings else None
    try:
        said = asked(declare, replace(named, elements=mesh))
    except UnavailableError as error:
        return Declaration(_unusable(str(error)))
    if not isinstance(said, Declaration) or senseless(said.info, names()):
        return Declaration(_unusable("what it says of itself cannot be read"))
    return said


def imported(named: Named) -> str:
    """Return why a model's module cannot be imported here, "" once it is."""
    module = known(named.name, "model").module
    try:
        import_module(module)
    except (Exception, SystemExit) as error:
        return f"it cannot be imported ({type(error).__name__}: {error})"
    return ""


def misfit(named: Named) -> str:
    """Return why a model has no such elements or settings, "" if it has; loaded in this process.

    Raises `UnavailableError` where it cannot be built at all.
    """
    try:
        named.build()
    except InputError as error:
        return str(error)
    return ""


def _found(named: Named) -> Any:
    """Return what is behind a name, loaded in this process, or None where it cannot be."""
    try:
        return known(named.name, "model").load()
    except (Exception, SystemExit):
        return None


def _settings(thing: Any) -> frozenset[str]:
    try:
        own = getattr(thing, "settings", None)
        names = own if own is not None else inspect.signature(thing).parameters
    except Exception:
        return frozenset()
    return frozenset(map(str, names)) - {"elements"}


def declare(named: Named) -> Declaration:
    """Return what a model says of itself, loaded in this process."""
    point = known(named.name, "model")
    try:
        thing = point.load()
    except (Exception, SystemExit) as error:
        return Declaration(_unusable(f"it cannot be imported ({type(error).__name__}: {error})"))
    try:
        parameters = inspect.signature(thing).parameters
        if "elements" not in parameters:
            return Declaration(_unusable("it takes no elements"))
        said = thing.info()
    except (Exception, SystemExit) as error:
        return Declaration(_unusable(f"its info() raises {type(error).__name__}: {error}"))
    if why := senseless(said, names()):
        return Declaration(_unusable(f"its info() {why}"))
    default = parameters["elements"].default
    own = default if _whole(default) else None
    return Declaration(_refined(named, plain(said)), _settings(thing), own)


def _whole(default: Any) -> bool:
    """Whether a default is elements: a number, or two."""
    some = default if isinstance(default, tuple) and len(default) == 2 else (default,)
    return all(type(n) is int for n in some)


def _refined(named: Named, info: Info) -> Info:
    """Return the `info` of a model with its settings, where its class says `info`."""
    if named.settings and not info.missing:
        try:
            own = _one(named, _coarser(named)).info()
        except Exception:  # settings that it does not have: said when it is built
            own = None
        if not senseless(own, names()):
            info = plain(own)
    given = dict(named.settings)
    if info.isolated and info.limit and given.keys() & {"beam", "shear"}:
        # A simulator's info is of its class, not of this one.
        exact = _exact(given.get("beam", info.limit), named.settings)
        info = replace(info, limit=exact.name, theory=exact.info().theory)
    return replace(info, isolated=info.isolated or bool(named.owner))


def _exact(name: str, settings: tuple[tuple[str, Any], ...]) -> Named:
    """Return the exact model `name`, of the same shear coefficient if it has one."""
    shear = tuple(pair for pair in settings if pair[0] == "shear")
    return Named(name, None, shear if "shear" in accepted(name) else ())


def _coarser(named: Named) -> Elements:
    """Return the elements of one mesh of a model: the coarser of two."""
    return named.elements[0] if isinstance(named.elements, tuple) else named.elements


def _unusable(why: str) -> Info:
    return Info("unknown", "", "", 0, missing=" ".join(why[:LONG].split()))


@lru_cache(maxsize=256)
def _built(named: Named) -> Any:
    info = declare(named).info
    if isinstance(named.elements, tuple):
        if info.refinements is None:
            raise InputError("elements", named.elements, "one number for this model")
        coarse, fine = (_one(named, n) for n in named.elements)
        return Richardson(coarse, fine, info.order)
    return _one(named, named.elements)


def _one(named: Named, elements: Elements) -> Any:
    thing = known(named.name, "model").load()
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
