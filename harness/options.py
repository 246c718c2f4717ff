"""What the command line's options mean: text to cases, models and lists of numbers."""

import shlex
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import wraps
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from analytic import InputError
from analytic.theory import BEAMS, Theory
from harness.case_file import load_cases
from harness.cases import Case, select
from harness.history_option import takes_history
from harness.models import Spec, parse, parse_analytic
from reference_models import UnavailableError, catalogue

MOST_ELEMENTS = 512
MOST_MODES = 100
MOST_REPEATS = 1000
MOST_POSES = 1_000_000
MOST_SIZES = 32
STAND_IN = "exudyn-beam"
"""The reference that stands for the paper's ANSYS: sheared beams between ideal joints."""

_HELP = {
    "cases": ("CASE,CASE", "Cases by name; default case1,case2, or all of --case-file."),
    "case-file": ("FILE", "TOML file with mechanisms and cases of your own."),
    "references": ("A,B", "Reference models: NAME, NAME@N, or NAME@N1+N2 to extrapolate."),
    "elements": ("S,S", "Elements a limb, as in 1,2,4-8."),
    "modes": ("I,I", "Mode numbers; default 1-6."),
    "model": ("NAME[@S]", f"Theory: {', '.join(BEAMS)}, with @S elements or @exact."),
    "shear": ("KAPPA", "Timoshenko's kappa: cowper (default), 0.9, 6/7 or a number."),
    "output": ("DIR", "Folder to write CSV, Markdown, LaTeX and figures to."),
}
_COST_HELP = {
    "elements": ("S,S", "Elements a limb, as in 1,2,4-8; default 1,2,4,8,16,32,64."),
    "references": ("A,B", "Simulators by name; default all that can run here."),
    "repeats": ("N", "How often everything is timed; default 7."),
    "batches": ("N,N", "Poses a call; default 1,10,100,1000,10000,100000."),
    "output": _HELP["output"],
}


@dataclass(frozen=True)
class Request:
    """The options as typed; what was left out is None."""

    cases: str | None
    case_file: str | None
    references: str | None
    elements: str | None
    modes: str | None
    model: str | None
    shear: str | None
    output: str | None
    history: Path | None

    @property
    def chosen(self) -> list[Case]:
        """The cases, by default the paper's two, or all of the user's file."""
        extra = load_cases(Path(self.case_file)) if self.case_file is not None else {}
        if self.cases is None:
            return list(extra.values()) or select(["case1", "case2"], {})
        return select(split("--cases", self.cases), extra)

    @property
    def shown(self) -> list[int]:
        """The mode numbers, by default 1 to 6."""
        return numbers("--modes", "1-6" if self.modes is None else self.modes, MOST_MODES)

    @property
    def kappa(self) -> str | float:
        """Timoshenko's shear coefficient, by default Cowper's."""
        return shear_coefficient("cowper" if self.shear is None else self.shear)

    @property
    def folder(self) -> Path | None:
        """Where to write, if anywhere."""
        return folder(self.output)

    def against(self, default: str) -> list[Spec]:
        """The reference models, by default those named in `default`."""
        given = default if self.references is None else self.references
        return [parse(name, "--references", self.kappa) for name in split("--references", given)]

    def steps(self, default: str) -> list[int]:
        """The numbers of elements, by default those of `default`."""
        given = default if self.elements is None else self.elements
        return numbers("--elements", given, MOST_ELEMENTS)

    @property
    def steps_or_none(self) -> list[int] | None:
        """The numbers of elements, or None where each model has its own."""
        return None if self.elements is None else self.steps("")

    def theory(self, default: str) -> Spec:
        """The analytic model, by default `default`."""
        given = default if self.model is None else self.model
        return parse_analytic(given, "--model", self.kappa)


@dataclass(frozen=True)
class CostRequest:
    """The options of `rps-bench cost` as typed; what was left out is None."""

    elements: str | None
    references: str | None
    repeats: str | None
    batches: str | None
    output: str | None
    history: Path | None

    @property
    def steps(self) -> list[int]:
        """The numbers of elements, by default 1 to 64, doubling."""
        given = "1,2,4,8,16,32,64" if self.elements is None else self.elements
        return _sizes("--elements", given, MOST_ELEMENTS)

    @property
    def programs(self) -> list[str]:
        """The simulators, by default all that can run here."""
        missing = {name: info.missing for name, info in catalogue()}
        if self.references is None:
            return [name for name, why in missing.items() if not why]
        chosen = split("--references", self.references)
        for name in chosen:
            if name not in missing:
                expected = f"some of {', '.join(missing)}, without @ (see --elements)"
                raise InputError("--references", name, expected)
            if missing[name]:
                raise UnavailableError(f"reference model {name!r} cannot run here: {missing[name]}")
        return chosen

    @property
    def rounds(self) -> int:
        """How often everything is timed, by default 7 times."""
        if self.repeats is None:
            return 7
        if not self.repeats.isdecimal() or not 1 <= int(self.repeats) <= MOST_REPEATS:
            expected = f"a whole number from 1 to {MOST_REPEATS}"
            raise InputError("--repeats", self.repeats, expected)
        return int(self.repeats)

    @property
    def poses(self) -> list[int]:
        """The batch sizes, by default 1 to 100,000 by tens."""
        given = "1,10,100,1000,10000,100000" if self.batches is None else self.batches
        return _sizes("--batches", given, MOST_POSES)

    @property
    def folder(self) -> Path | None:
        """Where to write, if anywhere."""
        return folder(self.output)


def _sizes(option: str, text: str, most: int) -> list[int]:
    found = numbers(option, text, most)
    if len(found) > MOST_SIZES:
        raise InputError(option, text, f"at most {MOST_SIZES} sizes, such as 1,2,4,8")
    return found


def takes_request(command: Callable[..., int]) -> Callable[..., int]:
    """Give a command all the options, handed over as one `Request`; its own options follow."""

    def typed(**given: Any) -> int:
        request = Request(**{field.name: given.pop(field.name) for field in fields(Request)})
        return command(request, **given)

    return _taking(_HELP, takes_history(typed), command)


def takes_cost_request(command: Callable[[CostRequest], int]) -> Callable[..., int]:
    """Give a command the options of `CostRequest`."""
    typed = takes_history(lambda **given: command(CostRequest(**given)))
    return _taking(_COST_HELP, typed, command)


def _taking(
    options: dict[str, tuple[str, str]], typed: Callable[..., int], command: Callable[..., int]
) -> Callable[..., int]:
    typed = wraps(command)(typed)
    for name, (metavar, text) in reversed(options.items()):
        typed = click.option(f"--{name}", metavar=metavar, help=text)(typed)
    return typed


WRITES = ("output", "history", "json", "markdown", "junit")
"""Options that say where to write, not what to compute."""


def as_typed() -> str:
    """Return the command that runs now with its options, but for where it writes."""
    context = click.get_current_context()
    words = ["rps-bench", context.info_name or ""]
    for option in context.command.params:
        name = option.name or ""
        source = context.get_parameter_source(name)
        if source is ParameterSource.COMMANDLINE and name not in WRITES:
            flag = context.params[name] is True
            words += [option.opts[0]] if flag else [option.opts[0], str(context.params[name])]
    return shlex.join(words)


def folder(text: str | None) -> Path | None:
    """Return the folder that --output names, if any."""
    if text == "":
        raise InputError("--output", "", "the name of a folder")
    return None if text is None else Path(text)


def numbers(option: str, text: str, most: int) -> list[int]:
    """Return "1,2,5-8" as whole numbers from 1 to `most`, ascending, without repeats."""
    expected = f"whole numbers from 1 to {most}, such as 1,2,5-8"
    found: set[int] = set()
    for part in text.split(","):
        low, dash, high = part.strip().partition("-")
        if not low.isdecimal() or (dash and not high.isdecimal()):
            raise InputError(option, text, expected)
        first, last = int(low), int(high or low)
        if not 1 <= first <= last <= most:
            raise InputError(option, text, expected)
        found.update(range(first, last + 1))
    return sorted(found)


def split(option: str, text: str) -> list[str]:
    """Return the names in `text`, separated by commas, each once."""
    found = [name.strip() for name in text.split(",")]
    if not all(found):
        raise InputError(option, text, "names separated by commas")
    return list(dict.fromkeys(found))


def shear_coefficient(text: str) -> str | float:
    """Return a named shear coefficient, or a number."""
    try:
        shear: str | float = float(text)
    except ValueError:
        shear = text
    try:
        Theory("timoshenko", shear)
    except InputError:
        raise InputError("--shear", text, "cowper, 0.9, 6/7 or a positive number") from None
    return shear


def available() -> str:
    """Return the reference models that can run here, by commas, the stand-in for ANSYS first."""
    found = [name for name, info in catalogue() if not info.missing]
    if not found:
        raise UnavailableError("no reference model can run here; `rps-bench models` says why")
    return ",".join(sorted(found, key=lambda name: (name != STAND_IN, name)))
