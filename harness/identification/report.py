"""What an identification says, as tables, a figure and files."""

import json
from collections.abc import Callable, Sequence
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from harness.figures import COLOURS, MARKERS, figure_files
from harness.identification.directions import (
    Direction,
    Quantity,
    directions,
    quantities,
    sensitivities,
)
from harness.identification.identify import LEVEL, Identification, Reading, identify, readings
from harness.identification.parameters import INERTIAS
from harness.identification.problem import Problem
from harness.identification.table import published_table
from harness.models import parse_analytic
from harness.tables import Cell, Number, Table, table_files

PARAMETERS = ("z_mm", "base_radius_mm", "platform_thickness_mm", "tilt_deg")
"""Fitted to the paper's table with intervals."""
CANDIDATES = (
    "z_mm",
    "base_radius_mm",
    "platform_radius_mm",
    "rod_diameter_mm",
    "young_GPa",
    "platform_thickness_mm",
    "azimuth_deg",
    "tilt_deg",
)
"""From which readings of the paper's table are chosen."""
MODELS = ("euler-bernoulli@3", "rayleigh@3", "timoshenko@3")
SHOWN = 3
"""Readings shown for each number of free parameters, with either frames."""
ALIKE = 2
"""Readings whose AICc differs by less are equally good."""
MIRRORED = (
    "mirrored frames: a slip and no mechanism: limbs of the right length that lean from the "
    "vertical to the wrong side"
)
PINNED, LOOSE = 0.05, 0.5
"""A deviation below which a combination is called pinned down, or known loosely."""


def model_label(problem: Problem) -> str:
    """Return theory, elements, inertia and frames of a model."""
    return _theory(problem) + (", mirrored frames" if problem.mirrored else "")


def _theory(problem: Problem) -> str:
    printed = f", {INERTIAS[problem.inertia]}" if problem.inertia != "disc" else ""
    return f"{problem.spec.label}{printed}"


def readings_table(ranked: Sequence[Reading]) -> Table:
    """Return the best readings of every number of free parameters, and what they miss [%]."""
    rows: list[tuple[Cell, ...]] = []
    for count, frames, some in _grouped(ranked):
        rows += [
            (count, frames, rank, _theory(r.problem), values_text(r),
             Number(100 * r.rms, 2), Number(100 * r.worst, 2), _criterion(r))
            for rank, r in enumerate(some[:SHOWN], start=1)
        ]  # fmt: skip
    columns = ("Free", "Frames", "Rank", "Model", "Fitted", "rms [%]", "worst [%]", "AICc")
    notes = (*_reading_notes(ranked), *(e for e in [MIRRORED] if any(_slips(ranked))))
    return Table("Readings ranked by free parameters", columns, tuple(rows), notes)


def _slips(ranked: Sequence[Reading]) -> list[bool]:
    return [r.problem.mirrored for r in ranked]


def _grouped(ranked: Sequence[Reading]) -> list[tuple[int, str, list[Reading]]]:
    """Return readings by number of free parameters and frames, best first."""
    order = sorted(ranked, key=lambda r: (len(r.x), r.problem.mirrored, r.rms))
    return [
        (count, "mirrored" if mirrored else "stated", list(group))
        for (count, mirrored), group in groupby(order, key=lambda r: (len(r.x), r.problem.mirrored))
    ]


def simplest(ranked: Sequence[Reading]) -> Reading:
    """Return, of all readings as good as the best by AICc, that of the fewest parameters."""
    known = [r for r in ranked if np.isfinite(r.criterion)]
    best = min((r.criterion for r in known), default=np.inf)
    good = [r for r in known if r.criterion <= best + ALIKE] or list(ranked)
    return min(good, key=lambda r: (len(r.x), r.rms))


def _reading_notes(ranked: Sequence[Reading]) -> list[str]:
    table, best = ranked[0].problem.table, simplest(ranked)
    return [
        f"of {table.source}; what is not named is as in {', '.join(c.name for c in table.cases)}",
        f"{len(ranked)} readings: every choice of so many candidates, under every model; rms over "
        "different values: a repeated mode counts once; *: at a bound",
        f"AICc: Akaike's criterion for few values; differences below {ALIKE} mean nothing. Fewest "
        f"parameters among the best: {model_label(best.problem)}, {values_text(best)}",
        closest_note(ranked),
    ]


def closest_note(ranked: Sequence[Reading]) -> str:
    """Return in words how near the closest reading comes to all values."""
    table, closest = ranked[0].problem.table, min(ranked, key=lambda r: r.worst)
    rounding = float((table.step / table.frequencies).max()) / 2
    if closest.worst <= rounding:
        return "the closest meets every value to its last digit"
    return (
        f"none meets all {table.frequencies.size} values: the closest is "
        f"{100 * closest.worst:.2f} % off somewhere, where rounding explains {100 * rounding:.3f} %"
    )


def _criterion(reading: Reading) -> Cell:
    return Number(reading.criterion, 1) if np.isfinite(reading.criterion) else "too few values"


def values_text(reading: Reading) -> str:
    """Return what a reading's parameters are fitted to; *: at a bound."""
    pairs = zip(reading.problem.names, reading.values, strict=True)
    text = ", ".join(f"{n} {v:.4g}{'*' if n in reading.held else ''}" for n, v in pairs)
    return text or "nothing"


def parameters_table(results: Sequence[Identification]) -> Table:
    """Return fitted parameters with their intervals, and whether what was given lies inside."""
    rows: list[tuple[Cell, ...]] = []
    notes = []
    for result in results:
        problem, fits = result.problem, result.fits
        label = model_label(problem)
        given = problem.from_x(problem.start)
        for k, name in enumerate(problem.names):
            both = [_end(v, o) for v, o in zip(fits.together[0, k], fits.open[0, k], strict=True)]
            inside = fits.together[0, k, 0] <= given[k] <= fits.together[0, k, 1]
            rows.append(
                (label, name, _number(fits.values[0, k]),
                 *(_number(v) for v in fits.alone[0, k]), *both,
                 _number(float(given[k])), "inside" if inside else "outside")
            )  # fmt: skip
        rms = float(np.sqrt(fits.minima.sums[0] / problem.table.weights.sum()))
        notes.append(
            f"{label}: rms {100 * rms:.2f} %, {noise_text(result)}; "
            f"{fits.reached[0]} starts met at this minimum"
        )
    level = f"{100 * LEVEL:.0f} %"
    notes += [
        f"profile likelihood: 'alone' holds each true value in {level} of tables, 'together' all "
        f"of them at once in at least {level}",
        "none (bound): the parameter's bound came first; the table sets no end before it",
    ]
    columns = (
        "Model", "Parameter", "Fitted", "alone: from", "to", "together: from", "to", "Given",
        "Given lies",
    )  # fmt: skip
    title = f"Parameters of {results[0].problem.table.source}"
    return Table(title, columns, tuple(rows), tuple(notes))


def noise_text(result: Identification) -> str:
    """Return in words how large the noise of a value is taken, and from where."""
    size = f"{100 * result.fits.noise[0]:.3g} % a value"
    if result.assumed is None:
        return f"noise {size}, from the residuals themselves ({result.fits.freedom} to spare)"
    if result.assumed == result.problem.table.rounding:
        return f"noise {size}, from the rounding of the table"
    return f"noise {size}, as given"


def _number(value: float) -> Number:
    digits = max(0, 3 - int(np.floor(np.log10(abs(value))))) if value else 3
    return Number(float(value), min(digits, 4))


def _end(value: float, opened: bool) -> Cell:
    return f"none ({_number(value)})" if opened else _number(value)


def residuals_table(results: Sequence[Identification]) -> Table:
    """Return what each fit leaves, by case and mode [%]."""
    rows: list[tuple[Cell, ...]] = []
    for result in results:
        for case, error in zip(result.problem.table.cases, result.error, strict=True):
            cells = [Number(100 * float(e), 2, signed=True) for e in error]
            rows.append((model_label(result.problem), case.name, *cells))
    modes = results[0].error.shape[1]
    columns = ("Model", "Case", *(f"f{i} [%]" for i in range(1, modes + 1)))
    return Table("What the fits leave: f over the table's, less 1", columns, tuple(rows))


def directions_table(found: Sequence[Direction], problem: Problem) -> Table:
    """Return the products of powers, from what the table pins down to what it cannot see."""
    rows: list[tuple[Cell, ...]] = []
    for d in found:
        known = np.isfinite(d.deviation)
        text = Number(100 * d.deviation, 2) if known and d.deviation < 10 else "over 1000"
        rows.append((str(d), text if known else "infinite", _verdict(d.deviation)))
    notes = (
        f"{model_label(problem)}; singular vectors of d ln f / d ln p at the fit, powers below 0.1 "
        "left out; theta and phi: tilt and azimuth themselves",
        "infinite: frequencies do not change at all along these, whatever the table; they tell "
        "neither scale nor E and rho raised alike",
    )
    columns = ("Product of powers", "1 sigma [%]", "The table")
    return Table("What the table pins down, and what not", columns, tuple(rows), notes)


def _verdict(deviation: float) -> str:
    if not np.isfinite(deviation):
        return "cannot see it"
    if deviation < PINNED:
        return "pins it down"
    return "knows it loosely" if deviation < LOOSE else "leaves it open"


def quantities_table(found: Sequence[Quantity], problem: Problem) -> Table:
    """Return the named combinations: value, and how well known before and after the table."""
    rows: list[tuple[Cell, ...]] = [
        (q.name, Number(q.value, 4), Number(100 * q.before, 1), Number(100 * q.after, 1),
         _verdict(q.after))
        for q in found
    ]  # fmt: skip
    notes = (
        f"{model_label(problem)}; E and rho as given, all else free within its bounds",
        "L: a limb without tilt; m, Jz: the platform's mass and polar moment of inertia",
    )
    columns = ("Combination", "Value", "by bounds, 1 sigma [%]", "with the table [%]", "The table")
    return Table("Named combinations", columns, tuple(rows), notes)


def profile_figure(results: Sequence[Identification]) -> Figure:
    """Return the profiles of every parameter, and below them what the fits leave."""
    names = results[0].problem.names
    table = results[0].problem.table
    columns = max(len(names), len(table.cases))
    figure = Figure(figsize=(3.1 * columns, 6.2), layout="constrained")
    grid = figure.add_gridspec(2, columns * len(table.cases))
    width = columns * len(table.cases) // len(names)
    for k, name in enumerate(names):
        axes = figure.add_subplot(grid[0, k * width : (k + 1) * width])
        for result, colour in zip(results, COLOURS, strict=False):
            _draw_profile(axes, result, k, colour)
        axes.set_xlabel(name.replace("_", " "), fontsize=9)
        axes.grid(alpha=0.25)
        axes.tick_params(labelsize=8)
        axes.set_ylim(0, None)
        if k == 0:
            axes.set_ylabel("rise of S over noise$^2$")
    for c, case in enumerate(table.cases):
        axes = figure.add_subplot(grid[1, c * columns : (c + 1) * columns])
        for k, result in enumerate(results):
            modes = np.arange(1, result.error.shape[1] + 1)
            axes.plot(
                modes + 0.12 * (k - 0.5), 100 * result.error[c], ls="none", marker=MARKERS[k],
                color=COLOURS[k], label=model_label(result.problem),
            )  # fmt: skip
        axes.axhline(0, color="0.4", lw=0.8)
        axes.set_title(case.name, fontsize=10)
        axes.set_xticks(modes, [f"$f_{i}$" for i in modes])
        axes.grid(alpha=0.25)
        axes.set_ylabel("left over [%]")
        axes.margins(y=0.15)
        if c == 0:
            axes.legend(fontsize=8)
    explained = "dots: fitted; grey: as given; dotted, dashed: 95 % intervals, alone and together"
    figure.suptitle(f"Fits to {table.source}\n{explained}", fontsize=10)
    return figure


def _draw_profile(axes: Any, result: Identification, k: int, colour: str) -> None:
    problem, fits = result.problem, result.fits
    x = np.zeros((result.profiles.at.shape[1], len(problem.names)))
    x[:, k] = result.profiles.at[k]
    height = (result.profiles.sums[k] - fits.minima.sums[0]) / fits.noise[0] ** 2
    axes.plot(problem.from_x(x)[:, k], height, color=colour, lw=1.4, label=model_label(problem))
    axes.plot(fits.values[0, k], 0, "o", color=colour, ms=4, clip_on=False)
    for ends, style in ((fits.alone, ":"), (fits.together, "--")):
        for value, opened in zip(ends[0, k], fits.open[0, k], strict=True):
            if not opened:
                axes.axvline(value, color=colour, ls=style, lw=0.8)
    axes.axvline(problem.from_x(problem.start)[k], color="0.5", lw=0.8)


def identification_files(done: Callable[[str], None] = lambda _: None) -> dict[str, bytes]:
    """Return what the paper's theoretical table says, as `rps-bench identify` does by default."""
    table = published_table()
    specs = [parse_analytic(label, "--model") for label in MODELS]
    results = [
        identify(Problem(table, specs[0], PARAMETERS, mirrored=slip)) for slip in (False, True)
    ]
    return files(results, readings(table, CANDIDATES, specs, {}, most=3, done=done))


def tables(results: Sequence[Identification], ranked: Sequence[Reading]) -> dict[str, Table]:
    """Return all tables by the stem of their files."""
    main = results[-1]
    values = dict(zip(main.problem.names, main.fits.values[0].tolist(), strict=True))
    found = {"identification": readings_table(ranked)} if ranked else {}
    found["identification-parameters"] = parameters_table(results)
    found["identification-residuals"] = residuals_table(results)
    if not any("." in name for name in values):
        noise = float(main.fits.noise[0])
        whole, x, J = sensitivities(main.problem, values)
        found["identification-directions"] = directions_table(
            directions(whole.names, J, noise), main.problem
        )
        named = quantities(whole, x, J, noise)
        found["identification-quantities"] = quantities_table(named, main.problem)
    return found


def files(results: Sequence[Identification], ranked: Sequence[Reading]) -> dict[str, bytes]:
    """Return everything as files: tables, one JSON with all readings, and the figure."""
    made = table_files(tables(results, ranked))
    made["identification.json"] = json.dumps(record(results, ranked), indent=1).encode()
    return made | figure_files(profile_figure(results), "identification")


def record(results: Sequence[Identification], ranked: Sequence[Reading]) -> dict[str, Any]:
    """Return fits and readings as plain data, in the units of the names."""
    return {
        "table": results[0].problem.table.source,
        "level": LEVEL,
        "fits": [
            {
                **_model(result.problem),
                "noise": float(result.fits.noise[0]),
                "noise_from": noise_text(result),
                "parameters": [
                    {
                        "name": name,
                        "value": float(result.fits.values[0, k]),
                        "alone": result.fits.alone[0, k].tolist(),
                        "together": result.fits.together[0, k].tolist(),
                        "open": result.fits.open[0, k].tolist(),
                    }
                    for k, name in enumerate(result.problem.names)
                ],
                "error": result.error.tolist(),
            }
            for result in results
        ],
        "readings": [
            {
                **_model(r.problem),
                "free": dict(zip(r.problem.names, r.values.tolist(), strict=True)),
                "rms": r.rms,
                "worst": r.worst,
                "aicc": r.criterion if np.isfinite(r.criterion) else None,
                "at_bound": list(r.held),
            }
            for _, _, some in _grouped(ranked)
            for r in some[: 4 * SHOWN]
        ],
    }


def _model(problem: Problem) -> dict[str, Any]:
    return {
        "model": problem.spec.label,
        "inertia": problem.inertia,
        "frames": "mirrored" if problem.mirrored else "stated",
    }
