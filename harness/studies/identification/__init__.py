"""Identification: which mechanism a table of frequencies belongs to."""

from typing import TYPE_CHECKING

from harness.bench import Bench
from harness.plan import Plan
from harness.request import Request
from harness.studies.identification.options import OPTIONS as OPTIONS

if TYPE_CHECKING:
    from harness.studies.identification.result import Identification

TAKES = ("case_file", "model", "references", "shear")
DEFAULTS = {"model": "euler-bernoulli@3", "references": "rayleigh@3,timoshenko@3"}
PAPER_CANDIDATES = ("z_mm", "base_radius_mm", "platform_radius_mm", "rod_diameter_mm", "young_GPa",
                    "platform_thickness_mm", "azimuth_deg", "tilt_deg")  # fmt: skip
"""From which readings of the paper's table are chosen."""
FRAMES = {"stated": (False,), "mirrored": (True,), "both": (False, True)}


def run(request: Request, bench: Bench) -> "Identification":
    """Return which mechanism a table of natural frequencies belongs to.

    Says how well the table knows each parameter, which products of powers it pins down and which it
    cannot see, what the fit leaves, and which readings with how many free parameters come closest.
    --model is fitted with intervals; readings are of that theory and of those in --references.
    """
    from pathlib import Path

    from harness.studies.identification.estimate import identify, readings
    from harness.studies.identification.problem import Problem
    from harness.studies.identification.result import Identification, solved
    from harness.studies.identification.table import published_table, read_table

    given = request.options
    ours = given["table"] == "published"
    if ours:
        table = published_table(given["method"] or "Theoretical", request.cases)
    else:
        table = read_table(Path(given["table"]), given["method"], request.cases)
    names = given["parameters"]
    chosen = given["candidates"] or (PAPER_CANDIDATES if ours else names)
    frames = FRAMES[given["frames"] or ("both" if ours else "stated")]
    bounds = _bounds(given["bounds"], names, chosen)
    of_fit = {name: pair for name, pair in bounds.items() if name in names}
    of_readings = {name: pair for name, pair in bounds.items() if name in chosen}
    models = tuple(dict.fromkeys((request.theory, *request.references)))
    problems = [
        Problem(table, models[0], names, given["inertia"], slip, of_fit) for slip in frames
    ]  # fmt: skip
    for model in models:  # refused before any work
        Problem(table, model, chosen, bounds=of_readings, argument="candidates")
    tell = bench.listener
    tell.expect(len(problems) + len(models) * (len(frames) + (False in frames)))
    fits, search = [], {"starts": given["starts"], "seed": given["seed"]}
    for problem in problems:
        fits.append(identify(problem, noise=given["noise"], **search))
        tell.done("parameters")
    ranked = readings(table, chosen, models, of_readings, most=given["free"], frames=frames,
                      seed=given["seed"], done=tell.done)  # fmt: skip
    return Identification(tuple(fits), tuple(ranked), tuple(solved(fits, ranked, bench)))


def _bounds(
    given: dict[str, tuple[float, float]], *known: tuple[str, ...]
) -> dict[str, tuple[float, float]]:
    from analytic import InputError

    names = sorted({name for some in known for name in some})
    for name in given:
        if name not in names:
            raise InputError("bounds", name, f"NAME=LOW..HIGH with one of {', '.join(names)}")
    return given


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: of the paper's table; of one's own cases there is none."""
    from reference_models import parse

    if plan.case_file or not all(case.published for case in plan.cases):
        return {}
    theory = parse(DEFAULTS["model"], "model")
    others = tuple(parse(name, "references") for name in DEFAULTS["references"].split(","))
    return {"identification": plan.request(theory=theory, references=others)}
