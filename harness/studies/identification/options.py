"""What `identify` takes beside the standard arguments."""

import math
from collections.abc import Callable

from analytic import InputError
from harness.request import Option
from harness.text import split


def _one_of(name: str, *known: str) -> Callable[[str], str]:
    def parse(text: str) -> str:
        if text not in known:
            raise InputError(name, text, f"one of {', '.join(known)}")
        return text

    return parse


def _whole(name: str, least: int, most: int) -> Callable[[str], int]:
    def parse(text: str) -> int:
        if not (text.isascii() and text.isdecimal() and least <= int(text[:12]) <= most):
            raise InputError(name, text, f"a whole number from {least} to {most}")
        return int(text)

    return parse


def _noise(text: str) -> float:
    value = _float(text)
    if not 0 < value <= 100:
        raise InputError("noise", text, "a percentage above 0, up to 100")
    return value / 100


def _bounds(text: str) -> dict[str, tuple[float, float]]:
    found = {}
    for one in text.split(",") if text else ():
        name, _, span = one.strip().partition("=")
        low, high = (_float(end) for end in span.partition("..")[::2])
        if not low < high or not (name.endswith("_deg") or low > 0):
            raise InputError("bounds", one, "NAME=LOW..HIGH, LOW below HIGH, lengths above 0")
        found[name] = low, high
    return found


def _float(text: str) -> float:
    """Return a finite number, or NaN, which every comparison refuses."""
    try:
        value = float(text)
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan


FITTED = "z_mm,base_radius_mm,platform_thickness_mm,tilt_deg"
OPTIONS = (
    Option("table", "FILE", "CSV file with columns case, f1, f2, ... [Hz], cases being those of "
           "--case-file or built in; default the paper's Table I.", "published", str),
    Option("method", "ROW", "Its row; of Table I Theoretical (default) or FEA.", None, str),
    Option("parameters", "P,P", "Fitted together, with intervals; of one case alone as "
           f"case2.z_mm. Default {FITTED}.", FITTED, lambda text: tuple(split("parameters", text))),
    Option("candidates", "P,P", "Readings are chosen from these; default eight for Table I, else "
           "--parameters.", None, lambda text: tuple(split("candidates", text))),
    Option("free", "N", "Most free parameters a reading; default 3.", "3", _whole("free", 0, 5)),
    Option("bounds", "P=LOW..HIGH,...", "As in z_mm=400..700.", "", _bounds),
    Option("inertia", "disc|printed", "disc (default), or printed, Eq. 8.", "disc",
           _one_of("inertia", "disc", "printed")),
    Option("frames", "stated|mirrored|both", "stated, mirrored (limbs lean to the wrong side, a "
           "slip) or both; default both for Table I, else stated.", None,
           _one_of("frames", "stated", "mirrored", "both")),
    Option("starts", "N", "Starts of each search; default 16.", "16", _whole("starts", 1, 256)),
    Option("noise", "PERCENT", "Relative standard deviation of a value; default the residuals' "
           "own, or rounding.", None, _noise),
    Option("seed", "N", "Of the search's points; default 0.", "0", _whole("seed", 0, 2**31)),
)  # fmt: skip
