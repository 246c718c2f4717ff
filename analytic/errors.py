"""The one way this bench refuses a bad argument."""

import difflib
import math
from collections.abc import Iterable
from typing import Any

import numpy as np


class InputError(ValueError):
    """A bad argument, said in one sentence: its name, its value and what was expected."""

    def __init__(self, argument: str, value: object, expected: str) -> None:
        super().__init__(f"{argument} = {_shown(value)}: expected {expected}")
        self.expected = expected

    def __reduce__(self) -> Any:
        """Return how another process makes this error: by its sentence."""
        return _said, (type(self), str(self))


class RefusedError(InputError):
    """A mechanism or a kind of pose that one model cannot take, whatever its numbers."""


class NotCertifiedError(ValueError):
    """A number that double precision cannot bound as closely as promised, said in one sentence."""

    def __init__(self, what: str) -> None:
        super().__init__(f"double precision cannot certify {what}")

    def __reduce__(self) -> Any:
        """Return how another process makes this error: by its sentence."""
        return _said, (type(self), str(self))


def _said(kind: type[ValueError], sentence: str) -> ValueError:
    error = kind.__new__(kind)
    ValueError.__init__(error, sentence)
    return error


def _shown(value: object) -> str:
    if isinstance(value, int) and value.bit_length() > 1000:
        return f"a whole number of {value.bit_length()} bits"
    text = str(value) if isinstance(value, (int, float, np.number)) else repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def unknown(argument: str, name: str, known: Iterable[str]) -> InputError:
    """Return the error of a name that is none of `known`: it says which was probably meant."""
    names = list(known)
    near = difflib.get_close_matches(name, names, 1)
    meant = f"; did you mean {near[0]}?" if near else ""
    expected = f"one of {', '.join(names)}{meant}" if names else "a known one, and there is none"
    return InputError(argument, name, expected)


def number(argument: str, value: Any, expected: str, *, positive: bool = False) -> float:
    """Return `value` as a finite float (above zero if `positive`), or raise `InputError`."""
    try:
        result = float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(argument, value, expected) from None
    if isinstance(value, (bool, str)) or not math.isfinite(result) or (positive and result <= 0):
        raise InputError(argument, value, expected)
    return result


def count(argument: str, value: Any, *, at_least: int = 1, at_most: int | None = None) -> int:
    """Return `value` as a whole number within the limits, or raise `InputError`."""
    expected = f"a whole number of at least {at_least}"
    if at_most is not None:
        expected += f" and at most {at_most}"
    if isinstance(value, (bool, str)) or not isinstance(value, (int, np.integer)):
        raise InputError(argument, value, expected)
    if value < at_least or (at_most is not None and value > at_most):
        raise InputError(argument, value, expected)
    return int(value)


def vector(argument: str, value: Any, expected: str) -> tuple[float, float, float]:
    """Return `value` as three finite floats, or raise `InputError`."""
    try:
        x, y, z = (float(component) for component in value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(argument, value, expected) from None
    if not all(map(math.isfinite, (x, y, z))):
        raise InputError(argument, value, expected)
    return x, y, z
