"""What a model says of itself, and whether it can be used at all."""

import json
from collections.abc import Collection
from dataclasses import dataclass, fields
from typing import Any

from analytic.model import Info

_WORDS = {str: "a text", bool: "true or false"}


@dataclass(frozen=True)
class Declaration:
    """All that is learnt of a model without running it.

    Attributes: its `info`; the names of its `settings` besides elements; its own number of
    `elements`, where it has one.
    """

    info: Info
    settings: frozenset[str] = frozenset()
    elements: int | tuple[int, int] | None = None


def plain(info: Info) -> Info:
    """Return an `info` that makes sense with none of its maker's own types in it."""
    given = {one.name: getattr(info, one.name) for one in fields(Info)}
    said = json.loads(json.dumps(given))
    own: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in said.items()}
    return Info(**own)


def senseless(info: Any, known: Collection[str]) -> str:
    """Return what of `info` cannot be used, in words that follow "its info()"; "" if all can.

    `known`: the names of all models.
    """
    if not isinstance(info, Info):
        return f"gives {type(info).__name__}, not Info"
    for one in fields(Info):
        value = getattr(info, one.name)
        expected = _expected(one.name, one.type, value)
        if expected:
            return f"says {one.name} = {value!r}, where {expected} was expected"
    for name in ("limit", "relaxed"):
        if (other := getattr(info, name)) and other not in known:
            return f"says {name} = {other!r}, which is no model of the catalogue"
    return ""


def _expected(name: str, kind: Any, value: object) -> str:
    """Return what was expected where `value` is not of a field's `kind`, "" where it is."""
    if kind in _WORDS:
        return "" if isinstance(value, kind) else _WORDS[kind]
    if kind is float:
        return "" if isinstance(value, (int, float)) else "a number"
    if name == "refinements" and value is None:
        return ""
    whole = isinstance(value, tuple) and all(type(n) is int and n > 0 for n in value)
    if isinstance(value, tuple) and whole and (name == "ladder" or len(value) == 2):
        return ""
    return "whole numbers of elements" if name == "ladder" else "two numbers of elements, or None"
