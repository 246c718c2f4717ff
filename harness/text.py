"""Texts to objects: what people write on the command line, in files, and in notebooks."""

import re
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from analytic import InputError
from analytic.model import Info
from analytic.theory import Theory
from harness import plugins  # noqa: F401  models of other packages stay out of this process
from harness.case import Case
from harness.case_file import load_cases
from harness.cases import select
from harness.presets import (
    DEFAULTS,
    PAPER_CASES,
    QUICKEST,
    TABLE_ONE,
    in_usual_order,
    quick,
    solid_truth,
)
from harness.request import Plan, Request
from reference_models import Named, UnavailableError, catalogue, parse

MOST_ELEMENTS = 512
MOST_MODES = 100
GROUPS: dict[str, tuple[str, ...] | None] = {
    "all": None, "usual": TABLE_ONE, "quick": QUICKEST,
}  # fmt: skip
"""Words for several models, and which; None: every simulator."""
_OUTSIDE = re.compile(r",(?![^\[]*\])")


def request(study: ModuleType | None, texts: Mapping[str, str | None]) -> Request:
    """Return what `texts` (argument to text, None where left out) ask of `study`, if of any.

    Raises `InputError` naming the argument that cannot be read.
    """
    given = {name: text for name, text in texts.items() if text is not None}
    own: dict[str, str] = getattr(study, "DEFAULTS", {})
    default = DEFAULTS | own
    shear = shear_coefficient(given.get("shear"))
    cases = chosen(given.get("cases"), given.get("case_file"), default.get("cases", PAPER_CASES))
    model, elements = (given.get(name) or default.get(name) for name in ("model", "elements"))
    named = given.get("references", default["references"])
    theory = parse(model, "model", **shear) if model else cases[0].theory.given(**shear)
    paper = ",".join(map(str, sorted({one.mode for case in cases for one in case.printed})))
    modes = given.get("modes") or own.get("modes") or paper or default["modes"]
    return Request(
        tuple(cases),
        theory,
        tuple(models(named, "references", **shear)),
        tuple(numbers("elements", elements, MOST_ELEMENTS)) if elements else None,
        tuple(numbers("modes", modes, MOST_MODES)),
        options(study, given),
        absent(named),
    )


def options(study: ModuleType | None, given: Mapping[str, str]) -> dict[str, Any]:
    """Return a study's own options, by name: what is `given`, or by default."""
    return {
        option.name: None if text is None else option.parse(text)
        for option in getattr(study, "OPTIONS", ())
        for text in [given.get(option.name, option.default)]
    }


def chosen(names: str | None, file: str | None, default: str) -> list[Case]:
    """Return the cases called `names`, else all of `file`, else those of `default`."""
    extra = load_cases(Path(file)) if file is not None else {}
    if names is None:
        return list(extra.values()) or select(default.split(","), {})
    return select(split("cases", names), extra)


def models(text: str, argument: str, **settings: Any) -> list[Named]:
    """Return the models that `text` names, separated by commas.

    "all": every simulator that can run here; "usual": one of each kind; "quick": those that answer
    within a second.
    """
    if text in GROUPS:
        found = [name for name, info in _group(text) if not info.missing]
        if not found:
            raise UnavailableError(
                "no simulator can run here, `rps-bench models` says why; "
                f"{argument} = 'timoshenko@exact' needs none"
            )
        some = [parse(name, argument, **settings) for name in in_usual_order(found)]
        return [quick(one) for one in some] if text == "usual" else some
    return [parse(name, argument, **settings) for name in split(argument, text)]


def absent(text: str) -> dict[str, str]:
    """Return why simulators of the group `text` cannot run here, by name; none of names."""
    if text not in GROUPS:
        return {}
    return {name: info.missing for name, info in _group(text) if info.missing}


def _group(text: str) -> list[tuple[str, Info]]:
    some = GROUPS[text]
    return [one for one in catalogue() if (one[1].isolated if some is None else one[0] in some)]


def numbers(argument: str, text: str, most: int) -> list[int]:
    """Return "1,2,5-8" as whole numbers from 1 to `most`, ascending, without repeats."""
    found: set[int] = set()
    for part in text.split(","):
        read = re.fullmatch("([0-9]{1,9})(?:-([0-9]{1,9}))?", part.strip())
        first, last = (int(end) for end in (read[1], read[2] or read[1])) if read else (0, 0)
        if not 1 <= first <= last <= most:
            raise InputError(argument, text, f"whole numbers from 1 to {most}, such as 1,2,5-8")
        found.update(range(first, last + 1))
    return sorted(found)


def split(argument: str, text: str) -> list[str]:
    """Return the names in `text`, separated by commas outside of brackets, each once."""
    found = [name.strip() for name in _OUTSIDE.split(text)]
    if not all(found):
        raise InputError(argument, text, "names separated by commas")
    return list(dict.fromkeys(found))


def shear_coefficient(text: str | None) -> dict[str, str | float]:
    """Return the setting `shear` that `text` means, none where it is left out."""
    if text is None:
        return {}
    try:
        shear: str | float = float(text)
    except ValueError:
        shear = text
    try:
        Theory("timoshenko", shear)
    except InputError:
        raise InputError("shear", text, "cowper, 0.9, 6/7 or a positive number") from None
    return {"shear": shear}


def plan(texts: dict[str, str | None]) -> Plan:
    """Return what `texts` ask of the main job; the references are all that can run here."""
    usual = {"references": "all", "elements": "1-8", "modes": DEFAULTS["modes"]}
    given = {name: text for name, text in texts.items() if text is not None}
    asked = request(None, usual | given)
    return Plan(**vars(asked), solid=solid_truth(), case_file="case_file" in given)
