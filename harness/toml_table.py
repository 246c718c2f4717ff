"""A table of a TOML file, read key by key in the units that its keys say, or refused in words."""

import math
from collections.abc import Iterable, Mapping
from typing import Any

from analytic import InputError
from analytic.errors import number, unknown, vector

Three = tuple[float, float, float]
DEGREES = math.pi / 180
UNITS = {
    "_mm": ("millimetres", lambda value: value / 1000),
    "_mm2": ("", lambda value: value * 1e-6),
    "_mm4": ("", lambda value: value * 1e-12),
    "_deg": ("degrees", lambda value: value * DEGREES),
    "_GPa": ("gigapascals", lambda value: value * 1e9),
    "_kg_m3": ("kg/m^3", float),
    "_kg": ("kilograms", float),
    "": ("", float),
}
"""What the ends of keys mean in words, and how their numbers become SI."""
NEEDED = object()
"""The default of what must be given."""


class Given:
    """A `table` that stands at `where` and has no other keys than `keys`; what it holds, in SI.

    Everything raises `InputError` naming the key, its value and what was expected.
    """

    def __init__(self, where: str, table: Any, keys: Iterable[str]) -> None:
        keys = dict.fromkeys(keys)
        if not isinstance(table, dict):
            raise InputError(where, table, f"a table with the keys {', '.join(keys)}")
        for key in table:
            if key not in keys:
                raise InputError(where, key, f"only the keys {', '.join(keys)}")
        self.where, self._table = where, table

    def __contains__(self, key: str) -> bool:
        return key in self._table

    def at(self, key: str) -> str:
        """Return what an error calls a key."""
        return f"{self.where}.{key}"

    def get(self, key: str, default: Any = None) -> Any:
        """Return what stands under a key, as it is."""
        return self._table.get(key, default)

    def refused(self, key: str, expected: str) -> InputError:
        """Return the error of what stands under a key."""
        return InputError(self.at(key), self.get(key), expected)

    def number(
        self,
        key: str,
        default: Any = NEEDED,
        *,
        positive: bool = False,
        within: tuple[float, float] | None = None,
    ) -> Any:
        """Return a number, or `default`; `within` these two, in the unit of the key."""
        if key not in self and default is not NEEDED:
            return default
        words, to_si = _unit(key)
        expected = f"a {'positive' if positive else 'finite'} number{words and f' of {words}'}"
        value = number(self.at(key), self.get(key), expected, positive=positive)
        if within is not None and not within[0] <= value <= within[1]:
            raise InputError(self.at(key), value, f"{within[0]:g} to {within[1]:g} {words}")
        return to_si(value)

    def pair(self, key: str, expected: str) -> tuple[float, float]:
        """Return two numbers."""
        given = self.get(key)
        if not isinstance(given, list) or len(given) != 2:
            raise self.refused(key, expected)
        _, to_si = _unit(key)
        first, second = (to_si(number(self.at(key), value, expected)) for value in given)
        return first, second

    def metres(self, key: str, default: Any = None) -> Three:
        """Return a point that is given in millimetres, or by a radius and an angle."""
        given = self.get(key, default)
        if isinstance(given, dict):
            polar = Given(self.at(key), given, ("radius", "angle_deg", "z"))
            r, angle = polar.number("radius"), polar.number("angle_deg")
            given = [r * math.cos(angle), r * math.sin(angle), polar.number("z", 0.0)]
        expected = "three coordinates in millimetres, or a radius and angle_deg"
        x, y, z = vector(self.at(key), given, expected)
        return x / 1000, y / 1000, z / 1000

    def tensor(self, key: str) -> Any:
        """Return an inertia tensor that is given as three moments or as three rows."""
        given = self.get(key)
        if isinstance(given, list) and not any(isinstance(row, list) for row in given):
            x, y, z = vector(
                self.at(key), given, "three moments of inertia, or three rows of three"
            )
            return ((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z))
        return given

    def one_of(self, key: str, known: Mapping[str, Any], default: str | None = None) -> Any:
        """Return what is known by the name under a key."""
        name = self.get(key, default)
        if not isinstance(name, str):
            raise InputError(self.at(key), name, f"one of {', '.join(known)}")
        if name not in known:
            raise unknown(self.at(key), name, known)
        return known[name]


def _unit(key: str) -> tuple[str, Any]:
    return next(unit for end, unit in UNITS.items() if key.endswith(end))
