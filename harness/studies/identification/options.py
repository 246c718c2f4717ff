"""What `identify` takes beside the standard arguments."""

from sys import float_info

from analytic import InputError
from harness.request import Option, one_of, real, whole
from harness.text import split


def _bounds(text: str) -> dict[str, tuple[float, float]]:
    found = {}
    for one in text.split(",") if text else ():
        name, _, span = one.strip().partition("=")
        try:
            low, high = map(real("bounds", ""), span.partition("..")[::2])
        except InputError:
            low = high = 0.0  # refused below, with all of it named
        if not low < high or not (name.endswith("_deg") or low > 0):
            raise InputError("bounds", one, "NAME=LOW..HIGH, LOW below HIGH, lengths above 0")
        found[name] = low, high
    return found


FITTED = "z_mm,base_radius_mm,platform_thickness_mm,tilt_deg"
OPTIONS = (
    Option("table", "FILE", "CSV file with columns case, f1, f2, ... [Hz], cases being those of "
           "--case-file or built in; default the paper's Table I.", "published", str),
    Option("method", "ROW", "Its row; of Table I Theoretical (default) or FEA.", None, str),
    Option("parameters", "P,P", "Fitted together, with intervals; of one case alone as "
           f"case2.z_mm. Default {FITTED}.", FITTED, lambda text: tuple(split("parameters", text))),
    Option("candidates", "P,P", "Readings are chosen from these; default eight for Table I, else "
           "--parameters.", None, lambda text: tuple(split("candidates", text))),
    Option("free", "N", "Most free parameters a reading; default 3.", "3", whole("free", 0, 5)),
    Option("bounds", "P=LOW..HIGH,...", "As in z_mm=400..700.", "", _bounds),
    Option("inertia", "disc|printed", "disc (default), or printed, Eq. 8.", "disc",
           one_of("inertia", "disc", "printed")),
    Option("frames", "stated|mirrored|both", "stated, mirrored (limbs lean to the wrong side, a "
           "slip) or both; default both for Table I, else stated.", None,
           one_of("frames", "stated", "mirrored", "both")),
    Option("starts", "N", "Starts of each search; default 16.", "16", whole("starts", 1, 256)),
    Option("noise", "PERCENT", "Relative standard deviation of a value; default the residuals' "
           "own, or rounding.", None, real("noise", "a percentage above 0, up to 100",
           float_info.min, 100, 0.01)),
    Option("seed", "N", "Of the search's points; default 0.", "0", whole("seed", 0, 2**31)),
)  # fmt: skip
