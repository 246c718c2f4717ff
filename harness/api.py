"""Studies from Python: the arguments of the command line, as texts or as objects."""

from collections.abc import Mapping
from os import PathLike, fspath
from typing import Any

from analytic import InputError
from analytic.errors import unknown
from harness.bench import Bench, refuse_others
from harness.request import Request
from harness.result import Result
from harness.studies import STANDARD, find
from harness.text import request
from harness.workers import LIMIT

FIELDS = {"cases": "cases", "references": "references", "elements": "elements",
          "modes": "shown", "model": "theory"}  # fmt: skip
"""What each argument that may be an object is called in a `Request`."""


def study(name: str, /, *, time_limit: float = LIMIT, **arguments: Any) -> Result:
    """Return the result of the study called `name`.

    `arguments` are those of its command, with underscores: texts as on the command line
    (`references="exudyn-cable@8"`, `modes="1-3"`, `case_file="mine.toml"`), or objects (`cases`:
    `Case`s; `references`: models; `model`: one; `elements`, `modes`: whole numbers). `time_limit`:
    seconds that a simulator may take for one pose.

    The result has `to_frame()`, `plot()`, `table()`, `sentences()` and `failures()`. Raises
    `InputError` naming the argument that is unknown or cannot be read.
    """
    module = find(name).load()
    options = {option.name for option in getattr(module, "OPTIONS", ())}
    known = {*getattr(module, "TAKES", STANDARD), *options}
    for argument in arguments:
        if argument not in known:
            raise unknown("argument", argument, sorted(known))
    texts, objects = {}, {}
    for argument, value in arguments.items():
        if isinstance(value, (str, PathLike)):
            texts[argument] = fspath(value)
        elif value is not None:
            objects[argument] = value
    asked = _with(request(module, texts), objects)
    if getattr(module, "EACH_REFERENCE", False) and len(asked.references) > 1:
        labels = ", ".join(model.label for model in asked.references)
        raise InputError("references", labels, "one, for this study")
    with Bench(time_limit) as bench:
        result: Result = module.run(asked, bench)
    return result


def _with(asked: Request, objects: Mapping[str, Any]) -> Request:
    """Return `asked` with `objects` in the place of what the texts meant."""
    changes: dict[str, Any] = {}
    options = dict(asked.options)
    for argument, value in objects.items():
        if argument not in FIELDS:
            options[argument] = value
        elif argument == "model" or not isinstance(value, (list, tuple, range)):
            changes[FIELDS[argument]] = value if argument == "model" else (value,)
        else:
            changes[FIELDS[argument]] = tuple(value)
    theory = (changes["theory"],) if "theory" in changes else ()
    refuse_others(changes.get("cases", ()), (*changes.get("references", ()), *theory))
    if "cases" in objects and "model" not in objects:
        changes["theory"] = changes["cases"][0].theory
    return asked.with_(**changes, options=options)
