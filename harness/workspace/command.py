"""`rps-bench workspace`: the regular workspace and the frequencies in it, Fig. 6."""

import time
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from analytic import InputError, Limits, Pose
from analytic.workspace import heights
from harness.cases import select
from harness.history_option import takes_history
from harness.models import Spec, parse
from harness.options import Request
from harness.tables import table_files
from harness.terminal import finish, progress, show, status, write
from harness.workspace.map import Grid, Region, solve, workspace_map

BATCHED, ONE_BY_ONE = "72x15", "12x4"
"""The default grid of models that take all poses at once, and of those that take one."""
LAYERS = 6
MOST_LAYERS = 50
MOST_POSES = 200_000


@click.command()
@click.option(
    "--model",
    metavar="NAME[@S]",
    default="timoshenko@exact",
    help="Any model; default timoshenko@exact. The paper's own: euler-bernoulli@3.",
)
@click.option("--modes", metavar="I,I", default="1-3", help="Mode numbers; default 1-3.")
@click.option("--layers", metavar="Z,Z", help="Heights z [mm]; default six over the cone.")
@click.option(
    "--grid",
    metavar="AxT",
    help=f"Azimuths x tilts; default {BATCHED}, or {ONE_BY_ONE} for a simulator.",
)
@click.option("--length-min-mm", metavar="L", default="200", help="Shortest limb; default 200.")
@click.option("--length-max-mm", metavar="L", default="1000", help="Longest limb; default 1000.")
@click.option(
    "--spherical-max-deg",
    metavar="ANGLE",
    default="45",
    help="Largest angle of a limb from the platform's normal; default 45 (none is printed).",
)
@click.option(
    "--revolute-max-deg",
    metavar="ANGLE",
    default="45",
    help="Largest angle of a limb from the vertical; default 45 (none is printed).",
)
@click.option("--shear", metavar="KAPPA", help="Timoshenko's kappa; default cowper.")
@click.option("--cases", metavar="CASE", help="Whose mechanism; default case1.")
@click.option("--case-file", metavar="FILE", help="TOML file with mechanisms of your own.")
@click.option("--output", metavar="DIR", default="workspace", help="Folder; default workspace.")
@takes_history
def workspace(
    grid: str | None,
    layers: str | None,
    length_min_mm: str,
    length_max_mm: str,
    spherical_max_deg: str,
    revolute_max_deg: str,
    history: Path | None,
    **given: str | None,
) -> int:
    """Map the frequencies over the regular workspace, layer by layer, as in Fig. 6.

    Writes surfaces, filled contours and data, and checks the paper's two statements on them:
    circular symmetry, and that frequencies fall with height. Modes are numbered by order.
    """
    from harness.figures import figure_files
    from harness.reproduce import tidy
    from harness.workspace.checks import height_table, region_table, symmetry_table, verdicts
    from harness.workspace.figures import (
        contour_figure,
        region_figure,
        ripple_figure,
        surface_figure,
    )
    from harness.workspace.rows import history_rows

    request = Request(references=None, elements=None, history=None, **given)
    shown, folder = request.shown, request.folder or Path("workspace")
    spec = parse(request.model or "", "--model", request.kappa)
    cases = request.chosen if request.case_file or request.cases else select(["case1"], {})
    if len(cases) != 1:
        raise InputError("--cases", request.cases, "one case, whose mechanism is mapped")
    limits = _limits(length_min_mm, length_max_mm, spherical_max_deg, revolute_max_deg)
    mechanism = cases[0].mechanism
    size = _grid(grid or (BATCHED if spec.analytic else ONE_BY_ONE), len(mechanism.limbs))
    wanted = None if layers is None else _layers(layers, *heights(mechanism, limits))
    region = Region.of(mechanism, limits)
    z = region.layers(LAYERS) if wanted is None else wanted

    drawn, count = Grid.of(region, z, *size), max(shown)
    total = int(drawn.wanted.sum())
    if not spec.analytic:
        _warn(spec, region, z, count, total)
    with progress(total) as done:
        data = workspace_map(region, drawn, spec, count, done)
    if not np.isfinite(data.frequencies).any():
        return status(data.answers.failures)
    # A batch is cheap enough to check the statements at every height, not only those drawn.
    fine = data
    if spec.analytic:
        fine = workspace_map(region, Grid.of(region, region.circles.z, *size), spec, count)
    tables = {
        "layers": region_table(region, data, shown),
        "symmetry": symmetry_table(fine, shown),
        "height": height_table(fine, shown),
    }
    show(*tables.values())
    for line in verdicts(region, fine, shown):
        click.echo(f"- {line}")
    files = {"map.csv": tidy(data.rows())} | table_files(tables)
    figures = {
        "workspace": region_figure(region, drawn),
        "contours": contour_figure(data, shown),
        "surfaces": surface_figure(data, shown),
        "ripple": ripple_figure(data, shown),
    }
    for stem, figure in figures.items():
        files |= figure_files(figure, stem)
    write(folder, files)
    ended = status(data.answers.failures)
    return max(ended, finish(history, more=history_rows(data) if history else ()))


def _limits(shortest: str, longest: str, spherical: str, revolute: str) -> Limits:
    low = _number("--length-min-mm", shortest, "millimetres from 0", 0.0)
    high = _number("--length-max-mm", longest, f"more millimetres than --length-min-mm = {low:g}")
    if high <= low:
        raise InputError("--length-max-mm", longest, f"more than --length-min-mm = {low:g}")
    angles = []
    for option, text in (("--spherical-max-deg", spherical), ("--revolute-max-deg", revolute)):
        expected = "degrees above 0 and at most 180"
        angle = _number(option, text, expected, 0.0)
        if not 0 < angle <= 180:
            raise InputError(option, text, expected)
        angles.append(float(np.radians(angle)))
    return Limits(low / 1000, high / 1000, *angles)


def _number(option: str, text: str, expected: str, least: float = -np.inf) -> float:
    try:
        value = float(text)
    except ValueError:
        raise InputError(option, text, expected) from None
    if not np.isfinite(value) or value < least:
        raise InputError(option, text, expected)
    return value


def _grid(text: str, limbs: int) -> tuple[int, int]:
    expected = f"AxT: azimuths, a multiple of the {limbs} limbs from 12 on, and 2 tilts or more"
    azimuths, _, tilts = text.partition("x")
    if not azimuths.isdecimal() or not tilts.isdecimal():
        raise InputError("--grid", text, expected)
    a, t = int(azimuths), int(tilts)
    if a % limbs or a < 12 or t < 2:
        raise InputError("--grid", text, expected)
    if a * t > MOST_POSES:
        raise InputError("--grid", text, f"at most {MOST_POSES} poses a layer")
    return a, t


def _layers(text: str, lowest: float, highest: float) -> NDArray[np.float64]:
    low, high = 1000 * lowest, 1000 * highest
    expected = f"up to {MOST_LAYERS} heights z between {low:.1f} and {high:.1f} mm, by commas"
    values = {_number("--layers", part, expected) for part in text.split(",")}
    if len(values) > MOST_LAYERS or not all(low <= value <= high for value in values):
        raise InputError("--layers", text, expected)
    return np.array(sorted(values)) / 1000


def _warn(spec: Spec, region: Region, z: NDArray[np.float64], count: int, total: int) -> None:
    """Say how long a simulator will take, by its second pose: the first one loads it."""
    solve(spec, region.mechanism, Pose(z[:1]), count)
    start = time.perf_counter()
    solve(spec, region.mechanism, Pose(z[:1]), count)
    seconds = time.perf_counter() - start
    minutes = seconds * total / 60
    click.echo(
        f"{spec.label}: {total} poses one by one at {seconds:.2g} s, about {minutes:.1f} min",
        err=True,
    )
