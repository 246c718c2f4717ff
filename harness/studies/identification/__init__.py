"""Identification: which mechanism a table of frequencies belongs to."""

from sys import float_info
from typing import TYPE_CHECKING

from analytic import InputError
from harness.bench import Bench
from harness.request import Option, Plan, Request, one_of, real, whole
from harness.text import split

if TYPE_CHECKING:
    from harness.studies.identification.result import Identification


def _bounds(text: str) -> dict[str, tuple[float, float]]:
    found = {}
    for one in text.split(",") if text else ():
        name, _, span = one.strip().partition("=")
        try:
            low, high = map(real("bounds", ""), span.partition("..")[::2])
        except InputError:
            low = high = 0.0  # refused below, with all of it named
        if not low < high:
            raise InputError("bounds", one, "NAME=LOW..HIGH, LOW below HIGH")
        found[name] = low, high
    return found


TAKES = ("case_file", "model", "references", "shear")
DEFAULTS = {"model": "euler-bernoulli@3", "references": "rayleigh@3,timoshenko@3"}
PAPER_CANDIDATES = ("z_mm", "base_radius_mm", "platform_radius_mm", "rod_diameter_mm", "young_GPa",
                    "platform_thickness_mm", "azimuth_deg", "tilt_deg")  # fmt: skip
"""From which readings of the paper's table are chosen."""
FRAMES = {"stated": (False,), "mirrored": (True,), "both": (False, True)}
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
           one_of("frames", *FRAMES)),
    Option("starts", "N", "Starts of each search; default 16.", "16", whole("starts", 1, 256)),
    Option("noise", "PERCENT", "Relative standard deviation of a value; default the residuals' "
           "own, or rounding.", None, real("noise", "a percentage above 0, up to 100",
           float_info.min, 100, 0.01)),
    Option("seed", "N", "Of the search's points; default 0.", "0", whole("seed", 0, 2**31)),
)  # fmt: skip


def run(request: Request, bench: Bench) -> "Identification":
    """Return which mechanism a table of natural frequencies belongs to.

    Says how well the table knows each parameter, which products of powers it pins down and which it
    cannot see, what the fit leaves, and which readings with how many free parameters come closest.
    --model is fitted with intervals; readings are of that theory and of those in --references.
    """
    from pathlib import Path

    from harness.studies.identification.estimate import identify, readings
    from harness.studies.identification.problem import INERTIAS, Problem
    from harness.studies.identification.result import Identification, solved
    from harness.studies.identification.table import published_table, read_table

    given = request.options
    printed = given["table"] == "published"
    ours = printed and all(case.prints_errors for case in request.cases)
    if printed:
        table = published_table(given["method"] or "Theoretical", request.cases)
    else:
        table = read_table(Path(given["table"]), given["method"], request.cases)
    names, bounds = given["parameters"], given["bounds"]
    chosen = given["candidates"] or (PAPER_CANDIDATES if ours else names)
    frames = FRAMES[given["frames"] or ("both" if ours else "stated")]
    known = sorted({*names, *chosen})
    for name in bounds:
        if name not in known:
            raise InputError("bounds", name, f"NAME=LOW..HIGH with one of {', '.join(known)}")
    problems = [
        Problem(table, request.theory, names, given["inertia"], slip, bounds) for slip in frames
    ]
    wholes = [
        Problem(table, model, chosen, inertia, slip, bounds, "candidates")
        for model in dict.fromkeys((request.theory, *request.references))
        for inertia in INERTIAS
        for slip in frames
        if inertia == "disc" or (problems[0].regular and not slip)  # one slip at most
    ]
    tell, fits = bench.listener, []
    tell.expect(len(problems) + len(wholes))
    for problem in problems:
        fits.append(identify(problem, given["noise"], given["starts"], given["seed"]))
        tell.done("parameters")
    ranked = readings(wholes, given["free"], given["seed"], tell.done)
    return Identification(tuple(fits), tuple(ranked), tuple(solved(fits, ranked, bench)))


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: of the paper's table; of one's own cases there is none."""
    from reference_models import parse

    if plan.case_file or not all(case.prints_errors for case in plan.cases):
        return {}
    theory = parse(DEFAULTS["model"], "model")
    others = tuple(parse(name, "references") for name in DEFAULTS["references"].split(","))
    return {"identification": plan.request(theory=theory, references=others)}
