"""`rps-bench identify`: which mechanism a published table of frequencies belongs to."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from analytic import InputError
from analytic.theory import BEAMS
from harness.history_option import takes_history
from harness.options import folder, shear_coefficient, split

if TYPE_CHECKING:
    from harness.identification.problem import Bounds
    from harness.identification.table import FrequencyTable

MOST_STARTS = 256
MOST_FREE = 5
FRAMES = {"stated": (False,), "mirrored": (True,), "both": (False, True)}


@click.command()
@click.option(
    "--table", "source", metavar="FILE", default="published",
    help="CSV file with columns case, f1, f2, ... [Hz]; default the paper's Table I.",
)  # fmt: skip
@click.option("--method", metavar="ROW", help="Its row; of Table I Theoretical (default) or FEA.")
@click.option(
    "--parameters", metavar="P,P", default="z_mm,base_radius_mm,platform_thickness_mm,tilt_deg",
    show_default=True, help="Fitted together, with intervals; of one case alone as case2.z_mm.",
)  # fmt: skip
@click.option(
    "--candidates", metavar="P,P",
    help="Readings are chosen from these; default eight for Table I, else --parameters.",
)  # fmt: skip
@click.option("--free", metavar="N", default="3", help="Most free parameters a reading; default 3.")
@click.option("--bounds", metavar="P=LOW..HIGH", multiple=True, help="As in z_mm=400..700.")
@click.option(
    "--model", metavar="A,B",
    help=f"Theories, as {', '.join(BEAMS)}, with @S elements or @exact; default all three with 3. "
    "The first is fitted with intervals, readings are of any.",
)  # fmt: skip
@click.option("--shear", metavar="KAPPA", default="cowper", help="Timoshenko's kappa.")
@click.option("--inertia", metavar="FORM", default="disc", help="disc (default) or printed, Eq. 8.")
@click.option(
    "--frames", metavar="WHICH",
    help="stated, mirrored (limbs lean to the wrong side, a slip) or both; default both for "
    "Table I, else stated.",
)  # fmt: skip
@click.option("--starts", metavar="N", default="16", help="Starts of each search; default 16.")
@click.option(
    "--noise", metavar="PERCENT",
    help="Relative standard deviation of a value; default the residuals' own, or rounding.",
)  # fmt: skip
@click.option("--seed", metavar="N", default="0", help="Of the search's points; default 0.")
@click.option("--case-file", metavar="FILE", help="TOML file with the table's cases.")
@click.option("--output", metavar="DIR", help="Folder for CSV, Markdown, LaTeX, JSON and figure.")
@takes_history
def identify(
    source: str,
    method: str | None,
    parameters: str,
    candidates: str | None,
    free: str,
    bounds: tuple[str, ...],
    model: str | None,
    shear: str,
    inertia: str,
    frames: str | None,
    starts: str,
    noise: str | None,
    seed: str,
    case_file: str | None,
    output: str | None,
    history: Path | None,
) -> int:
    """Fit a mechanism's parameters to a table of natural frequencies.

    Says how well the table knows each of them, which products of powers it pins down and which it
    cannot see, what the fit leaves, and which readings with how many free parameters come closest.
    """
    from harness.identification.identify import identify, readings
    from harness.identification.parameters import INERTIAS
    from harness.identification.problem import Problem
    from harness.identification.report import CANDIDATES, MODELS, files, tables
    from harness.identification.rows import history_rows
    from harness.identification.summary import sentences
    from harness.models import parse_analytic
    from harness.terminal import finish, progress, show, write

    target, ours = folder(output), source == "published"
    table = _table(source, method, case_file)
    names = split("--parameters", parameters)
    if candidates is None:
        candidates = ",".join(CANDIDATES) if ours else parameters
    chosen = split("--candidates", candidates)
    kappa = shear_coefficient(shear)
    labels = MODELS if model is None else split("--model", model)
    specs = [parse_analytic(label, "--model", kappa) for label in labels]
    inertia = _one_of("--inertia", inertia, list(INERTIAS))
    mirrored = FRAMES[_one_of("--frames", frames or ("both" if ours else "stated"), list(FRAMES))]
    given = _bounds(bounds, {*names, *chosen})
    of_fit = {name: pair for name, pair in given.items() if name in names}
    of_readings = {name: pair for name, pair in given.items() if name in chosen}
    relative, seeded = _noise(noise), _whole("--seed", seed, 0, 2**31)
    begun = _whole("--starts", starts, 1, MOST_STARTS)
    most = _whole("--free", free, 0, MOST_FREE)
    problems = [Problem(table, specs[0], tuple(names), inertia, slip, of_fit) for slip in mirrored]
    # Refused before any work.
    Problem(table, specs[0], tuple(chosen), bounds=of_readings, option="--candidates")
    with progress(len(problems) + len(specs) * (len(mirrored) + (False in mirrored))) as done:
        results = []
        for problem in problems:
            results.append(identify(problem, noise=relative, starts=begun, seed=seeded))
            done("parameters")
        ranked = readings(
            table, chosen, specs, of_readings, most=most, frames=mirrored, seed=seeded, done=done
        )
    show(*tables(results, ranked).values())
    for line in sentences(results, ranked):
        click.echo(f"- {line}")
    write(target, files(results, ranked) if target is not None else {})
    return finish(history, more=history_rows(results, ranked) if history else ())


def _table(source: str, method: str | None, case_file: str | None) -> "FrequencyTable":
    from harness.case_file import load_cases
    from harness.identification.table import published_table, read_table

    if source == "published":
        return published_table("Theoretical" if method is None else method)
    extra = {} if case_file is None else load_cases(Path(case_file))
    return read_table(Path(source), method, extra)


def _one_of(option: str, text: str, known: list[str]) -> str:
    if text not in known:
        raise InputError(option, text, f"one of {', '.join(known)}")
    return text


def _whole(option: str, text: str, least: int, most: int) -> int:
    if not text.isdecimal() or not least <= int(text) <= most:
        raise InputError(option, text, f"a whole number from {least} to {most}")
    return int(text)


def _noise(text: str | None) -> float | None:
    if text is None:
        return None
    value = _float(text)
    if not 0 < value <= 100:
        raise InputError("--noise", text, "a percentage above 0, up to 100")
    return value / 100


def _bounds(texts: tuple[str, ...], names: set[str]) -> "Bounds":
    found = {}
    for text in texts:
        name, _, span = text.partition("=")
        low, _, high = span.partition("..")
        pair = _float(low), _float(high)
        angle = name.endswith("_deg")
        if name not in names or not pair[0] < pair[1] or not (angle or pair[0] > 0):
            expected = f"NAME=LOW..HIGH, LOW below HIGH, NAME one of {', '.join(sorted(names))}"
            raise InputError("--bounds", text, expected)
        found[name] = pair
    return found


def _float(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan
