"""What `identify` takes beside the standard arguments."""

import math

from analytic import InputError
from harness.request import Option

MOST_STARTS, MOST_FREE, MOST_SEED = 256, 5, 2**31


def _one_of(name: str, *known: str) -> Option:
    """Return an option with one of some words; its help is added by `_with`."""

    def parse(text: str) -> str:
        if text not in known:
            raise InputError(name, text, f"one of {', '.join(known)}")
        return text

    return Option(name, "|".join(known), "", None, parse)


def _with(option: Option, text: str, default: str | None = None) -> Option:
    return Option(option.name, option.metavar, text, default, option.parse)


def _whole(name: str, least: int, most: int) -> Option:
    def parse(text: str) -> int:
        if not (text.isascii() and text.isdecimal() and least <= int(text[:12]) <= most):
            raise InputError(name, text, f"a whole number from {least} to {most}")
        return int(text)

    return Option(name, "N", "", None, parse)


def _names(name: str) -> Option:
    def parse(text: str) -> tuple[str, ...]:
        from harness.text import split

        return tuple(split(name, text))

    return Option(name, "P,P", "", None, parse)


def _noise(text: str) -> float:
    value = _float(text)
    if not 0 < value <= 100:
        raise InputError("noise", text, "a percentage above 0, up to 100")
    return value / 100


def _bounds(text: str) -> dict[str, tuple[float, float]]:
    found = {}
    for one in text.split(",") if text else ():
        name, _, span = one.strip().partition("=")
        low, _, high = span.partition("..")
        pair = _float(low), _float(high)
        if not pair[0] < pair[1] or not (name.endswith("_deg") or pair[0] > 0):
            raise InputError("bounds", one, "NAME=LOW..HIGH, LOW below HIGH, lengths above 0")
        found[name] = pair
    return found


def _float(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan


OPTIONS = (
    Option("table", "FILE", "CSV file with columns case, f1, f2, ... [Hz], cases being those of "
           "--case-file or built in; default the paper's Table I.", "published", str),
    Option("method", "ROW", "Its row; of Table I Theoretical (default) or FEA.", None, str),
    _with(_names("parameters"), "Fitted together, with intervals; of one case alone as "
          "case2.z_mm. Default z_mm,base_radius_mm,platform_thickness_mm,tilt_deg.",
          "z_mm,base_radius_mm,platform_thickness_mm,tilt_deg"),
    _with(_names("candidates"), "Readings are chosen from these; default eight for Table I, else "
          "--parameters."),
    _with(_whole("free", 0, MOST_FREE), "Most free parameters a reading; default 3.", "3"),
    Option("bounds", "P=LOW..HIGH,...", "As in z_mm=400..700.", "", _bounds),
    _with(_one_of("inertia", "disc", "printed"), "disc (default), or printed, Eq. 8.", "disc"),
    _with(_one_of("frames", "stated", "mirrored", "both"), "stated, mirrored (limbs lean to the "
          "wrong side, a slip) or both; default both for Table I, else stated."),
    _with(_whole("starts", 1, MOST_STARTS), "Starts of each search; default 16.", "16"),
    Option("noise", "PERCENT", "Relative standard deviation of a value; default the residuals' "
           "own, or rounding.", None, _noise),
    _with(_whole("seed", 0, MOST_SEED), "Of the search's points; default 0.", "0"),
)  # fmt: skip
