"""What the command line's options mean: text to cases, models and lists of numbers."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path

import click

from analytic import InputError
from analytic.theory import BEAMS, Theory
from harness.case_file import load_cases
from harness.cases import Case, select
from harness.models import Spec, parse, parse_analytic
from reference_models import UnavailableError, catalogue

MOST_ELEMENTS = 512
MOST_MODES = 100
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
        if self.output == "":
            raise InputError("--output", "", "the name of a folder")
        return None if self.output is None else Path(self.output)

    def against(self, default: str) -> list[Spec]:
        """The reference models, by default those named in `default`."""
        given = default if self.references is None else self.references
        return [parse(name, "--references", self.kappa) for name in split("--references", given)]

    def steps(self, default: str) -> list[int]:
        """The numbers of elements, by default those of `default`."""
        given = default if self.elements is None else self.elements
        return numbers("--elements", given, MOST_ELEMENTS)

    def theory(self, default: str) -> Spec:
        """The analytic model, by default `default`."""
        given = default if self.model is None else self.model
        return parse_analytic(given, "--model", self.kappa)


def takes_request(command: Callable[[Request], int]) -> Callable[..., int]:
    """Give a command all the options, handed over as one `Request`."""

    @wraps(command)
    def typed(**given: str | None) -> int:
        return command(Request(**given))

    for name, (metavar, text) in reversed(_HELP.items()):
        typed = click.option(f"--{name}", metavar=metavar, help=text)(typed)
    return typed


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
