"""TOML files, read key by key in the units that their keys say, or refused in words."""

import math
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from analytic import InputError
from analytic.errors import number, unknown, vector
from analytic.mechanism import DENSITY, LARGEST, SMALLEST, STIFFNESS

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
LENGTH = 1000 * SMALLEST, 1000 * LARGEST
GIGAPASCALS = STIFFNESS[0] / 1e9, STIFFNESS[1] / 1e9
POSITIVE = {
    **dict.fromkeys(("young_GPa", "shear_GPa"), GIGAPASCALS),
    "density_kg_m3": DENSITY,
    **dict.fromkeys(("rod_diameter_mm", "diameter_mm", "base_radius_mm", "platform_radius_mm",
                     "platform_thickness_mm", "radius_mm", "thickness_mm", "length_mm"), LENGTH),
    **dict.fromkeys(("platform_mass_kg", "mass_kg", "body_kg", "area_mm2"), (0.0, math.inf)),
}  # fmt: skip
"""Keys whose numbers are above zero, and the least and the largest, in the key's own unit."""
DEFAULTS: dict[str, Any] = {
    **dict.fromkeys(("heading_deg", "bore_mm", "stiffness_N_m", "stiffness_Nm_rad", "yaw_deg",
                     "pitch_deg", "roll_deg", "z"), 0.0),
    **dict.fromkeys(("length_mm", "largest_deg"), None),
    **dict.fromkeys(("slider", "published", "title"), ""),
    "centre_mm": (0, 0, 0), "limbs": 3, "copies": 1, "inertia": "disc", "frame": "base",
    "payloads": (), "tilt_stiffness_Nm_rad": {}, "errata": (), "mechanism": "paper",
    "model": "euler-bernoulli",
}  # fmt: skip
"""What keys mean that are left out; others are needed."""
DIGITS = 4300
"""Digits of a whole number that Python reads at most."""


def read_toml(path: Path, argument: str = "case_file", hint: str = "") -> dict[str, Any]:
    """Return what a TOML file says; raises `InputError` naming the `argument`, and the line.

    `hint`: what else might be meant where it cannot be read.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
        return tomllib.loads(text)
    except OSError as error:
        expected = f"a readable file ({error.strerror or error}){hint}"
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        expected = f"a TOML file ({error})"
    except ValueError:
        where = _line(text, lambda line: max(map(len, re.findall(r"[\d_]+", line)), default=0))
        expected = f"at most {DIGITS} digits in {where}"
    except RecursionError:
        expected = f"fewer brackets in {_line(text, lambda line: sum(map(line.count, '[{')))}"
    raise InputError(argument, str(path), expected)


def _line(text: str, size: Callable[[str], int]) -> str:
    """Return the number of the line of the largest `size`, and the key that it gives."""
    lines = text.splitlines()
    worst = max(range(len(lines)), key=lambda k: size(lines[k]))
    return f"{lines[worst].partition('=')[0].strip()[:40]} of line {worst + 1}"


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

    def get(self, key: str) -> Any:
        """Return what stands under a key, as it is, or by default."""
        return self._table.get(key, DEFAULTS.get(key))

    def refused(self, key: str, expected: str) -> InputError:
        """Return the error of what stands under a key."""
        return InputError(self.at(key), self.get(key), expected)

    def number(self, key: str) -> Any:
        """Return a number, positive and within its limits as `POSITIVE` says, or its default."""
        if key not in self and key in DEFAULTS:
            return DEFAULTS[key]
        words, to_si = _unit(key)
        positive = key in POSITIVE
        expected = f"a {'positive' if positive else 'finite'} number{words and f' of {words}'}"
        value = number(self.at(key), self.get(key), expected, positive=positive)
        low, high = POSITIVE.get(key, (-math.inf, math.inf))
        if not low <= value <= high:
            raise InputError(self.at(key), value, f"{low:g} to {high:g} {words}")
        return to_si(value)

    def many(self, key: str, expected: str) -> list[Any]:
        """Return a list that is not empty, or nothing where it may be left out."""
        found = self.get(key)
        if key in self and not (isinstance(found, list) and found):
            raise self.refused(key, expected)
        return list(found or ())

    def pair(self, key: str, expected: str) -> tuple[float, float]:
        """Return two numbers."""
        given = self.get(key)
        if not isinstance(given, list) or len(given) != 2:
            raise self.refused(key, expected)
        _, to_si = _unit(key)
        first, second = (to_si(number(self.at(key), one, expected)) for one in given)
        return first, second

    def vector(self, key: str, expected: str) -> Three:
        """Return three numbers as they are."""
        return vector(self.at(key), self.get(key), expected)

    def metres(self, key: str) -> Three:
        """Return a point that is given in millimetres, or by a radius and an angle."""
        given = self.get(key)
        if isinstance(given, dict):
            polar = Given(self.at(key), given, ("radius", "angle_deg", "z"))
            r, angle = polar.number("radius"), polar.number("angle_deg")
            given = [r * math.cos(angle), r * math.sin(angle), polar.number("z")]
        expected = "three coordinates in millimetres, or a radius and angle_deg"
        x, y, z = vector(self.at(key), given, expected)
        return x / 1000, y / 1000, z / 1000

    def tensor(self, key: str) -> Any:
        """Return an inertia tensor that is given as three moments or as three rows."""
        given = self.get(key)
        if isinstance(given, list) and not any(isinstance(row, list) for row in given):
            x, y, z = self.vector(key, "three moments of inertia, or three rows of three")
            return ((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z))
        return given

    def one_of(self, key: str, known: Mapping[str, Any]) -> Any:
        """Return what is known by the name under a key."""
        name = self.get(key)
        if not isinstance(name, str):
            raise self.refused(key, f"one of {', '.join(known)}")
        if name not in known:
            raise unknown(self.at(key), name, known)
        return known[name]


def _unit(key: str) -> tuple[str, Any]:
    return next(unit for end, unit in UNITS.items() if key.endswith(end))
