"""What an identification says: tables, sentences, and mechanisms for the history."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.bench import SPARE, Bench, label
from harness.cases import Case
from harness.result import Result
from harness.rows import mode_rows, settings
from harness.studies.identification.directions import (
    Direction,
    Quantity,
    directions,
    quantities,
    sensitivities,
)
from harness.studies.identification.estimate import LEVEL, Fitted, Reading
from harness.studies.identification.parameters import INERTIAS, described
from harness.studies.identification.problem import Problem
from harness.tables import Cell, Number, Table
from harness.workers import Failure

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

SHOWN, KEPT = 3, 12
"""Readings shown, and kept as numbers, for each number of free parameters, with either frames."""
ALIKE = 2
"""Readings whose AICc differs by less are equally good."""
MIRRORED = (
    "mirrored frames: a slip and no mechanism: limbs of the right length that lean from the "
    "vertical to the wrong side"
)
ENDS = ("alone_from", "alone_to", "together_from", "together_to")
"""Columns of the ends of 95 % intervals."""
PINNED, LOOSE = 0.05, 0.5
"""A deviation below which a combination is called pinned down, or known loosely."""
IDENTIFIED = "identified"
"""The case in a row: a fitted mechanism is not that of the table's case, which is in `settings`."""


@dataclass(frozen=True)
class Identification(Result):
    """What a table of frequencies says of the mechanism that it belongs to.

    Attributes: `fits` of the parameters with intervals, one for each kind of frames; `readings`,
    best first; `kept`, rows of the history.
    """

    fits: tuple[Fitted, ...]
    readings: tuple[Reading, ...]
    kept: tuple[dict[str, Any], ...]

    def rows(self) -> list[dict[str, Any]]:
        """Return what the models say of the fitted mechanisms."""
        return list(self.kept)

    def to_frame(self) -> "pd.DataFrame":
        """Return one row a fit or reading and parameter, in the unit of the parameter's name.

        Ends of 95 % intervals of the parameter alone, and of all together; NaN where none is known.
        """
        import pandas as pd

        rows: list[dict[str, Any]] = []
        for one in self.fits:
            how = _about(one.problem) | {"kind": "fit", "rank": 1, **_errors(one)}
            for k, name in enumerate(one.problem.names):
                ends = (*one.fits.alone[0, k], *one.fits.together[0, k])
                own = {"parameter": name, "value": one.fits.values[0, k]}
                bound = {"at_bound": bool(one.fits.open[0, k].any())}
                rows.append(how | own | dict(zip(ENDS, ends, strict=True)) | bound)
        for _, _, some in _grouped(self.readings):
            for rank, r in enumerate(some[:KEPT], start=1):
                how = _about(r.problem) | {
                    "kind": "reading", "rank": rank, "rms_percent": 100 * r.rms,
                    "worst_percent": 100 * r.worst, "aicc": r.criterion,
                }  # fmt: skip
                pairs = zip(r.problem.names, r.values.tolist(), strict=True)
                rows += [
                    how | {"parameter": n, "value": v, "at_bound": n in r.held} for n, v in pairs
                ] or [how]
        return pd.DataFrame(rows)

    def tables(self) -> dict[str, Table]:
        """Return readings, parameters, what is left, and what the table pins down."""
        main = self.fits[-1]
        found = {"": readings_table(self.readings)} if self.readings else {}
        found["-parameters"] = parameters_table(self.fits)
        found["-residuals"] = residuals_table(self.fits)
        if not any("." in name for name in main.problem.names):
            noise = float(main.fits.noise[0])
            whole, x, J = sensitivities(main.problem, main.fitted)
            found["-directions"] = directions_table(
                directions(whole.names, J, noise), main.problem
            )  # fmt: skip
            found["-quantities"] = quantities_table(quantities(whole, x, J, noise), main.problem)
        return found

    def figures(self) -> dict[str, "Figure"]:
        """Return the profiles of every parameter, and below them what the fits leave."""
        from harness.studies.identification.picture import profile_figure

        return {"": profile_figure(self.fits)}

    def sentences(self) -> list[str]:
        """Return what the fits and readings say; nothing of what was not asked for."""
        from harness.studies.identification.sentences import sentences

        return sentences(self.fits, self.readings)


def _about(problem: Problem) -> dict[str, Any]:
    return {
        "table": problem.table.source,
        "model": label(problem.model),
        "inertia": problem.inertia,
        "frames": "mirrored" if problem.mirrored else "stated",
        "free": len(problem.names),
    }


def _errors(one: Fitted) -> dict[str, float]:
    worst = 100 * float(np.abs(one.error).max())
    return {"rms_percent": 100 * one.rms, "worst_percent": worst, "aicc": np.nan}


def model_label(problem: Problem) -> str:
    """Return theory, elements, inertia and frames of a model."""
    return _theory(problem) + (", mirrored frames" if problem.mirrored else "")


def _theory(problem: Problem) -> str:
    printed = f", {INERTIAS[problem.inertia]}" if problem.inertia != "disc" else ""
    return f"{label(problem.model)}{printed}"


def readings_table(ranked: Sequence[Reading]) -> Table:
    """Return the best readings of every number of free parameters, and what they miss [%]."""
    rows: list[tuple[Cell, ...]] = []
    for count, frames, some in _grouped(ranked):
        rows += [
            (count, frames, rank, _theory(r.problem), values_text(r),
             Number(100 * r.rms, 2), Number(100 * r.worst, 2),
             Number(r.criterion, 1) if np.isfinite(r.criterion) else "too few values")
            for rank, r in enumerate(some[:SHOWN], start=1)
        ]  # fmt: skip
    columns = ("Free", "Frames", "Rank", "Model", "Fitted", "rms [%]", "worst [%]", "AICc")
    table, best = ranked[0].problem.table, simplest(ranked)
    notes = [
        f"of {table.source}; what is not named is as in {', '.join(c.name for c in table.cases)}",
        f"{len(ranked)} readings: every choice of so many candidates, under every model; rms over "
        "different values: a repeated mode counts once; *: at a bound",
        f"AICc: Akaike's criterion for few values; differences below {ALIKE} mean nothing. Fewest "
        f"parameters among the best: {model_label(best.problem)}, {values_text(best)}",
        closest_note(ranked),
    ]
    if any(r.problem.mirrored for r in ranked):
        notes.append(MIRRORED)
    return Table("Readings ranked by free parameters", columns, tuple(rows), tuple(notes))


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


def values_text(reading: Reading) -> str:
    """Return what a reading's parameters are fitted to; *: at a bound."""
    pairs = zip(reading.problem.names, reading.values, strict=True)
    text = ", ".join(f"{n} {v:.4g}{'*' if n in reading.held else ''}" for n, v in pairs)
    return text or "nothing"


def parameters_table(results: Sequence[Fitted]) -> Table:
    """Return fitted parameters with their intervals, and whether what was given lies inside."""
    rows: list[tuple[Cell, ...]] = []
    notes = []
    for result in results:
        problem, fits = result.problem, result.fits
        name = model_label(problem)
        given = problem.from_x(problem.start)
        for k, parameter in enumerate(problem.names):
            both = [_end(v, o) for v, o in zip(fits.together[0, k], fits.open[0, k], strict=True)]
            inside = fits.together[0, k, 0] <= given[k] <= fits.together[0, k, 1]
            rows.append(
                (name, parameter, _number(fits.values[0, k]),
                 *(_number(v) for v in fits.alone[0, k]), *both,
                 _number(float(given[k])), "inside" if inside else "outside")
            )  # fmt: skip
        notes.append(
            f"{name}: rms {100 * result.rms:.2f} %, {noise_text(result)}; "
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


def noise_text(result: Fitted) -> str:
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


def residuals_table(results: Sequence[Fitted]) -> Table:
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


def solved(fits: Sequence[Fitted], ranked: Sequence[Reading], bench: Bench) -> list[dict[str, Any]]:
    """Return rows for the history: what the models say of what was fitted.

    Of every fit, and of the best reading of each number of free parameters; those with mirrored
    frames left out, for they are no mechanism.
    """
    found = {_key(one.problem): (one.problem, one.fitted) for one in fits}
    best: dict[int, Reading] = {}
    for reading in sorted(ranked, key=lambda reading: reading.rms):
        if len(reading.x) and not reading.problem.mirrored:
            best.setdefault(len(reading.x), reading)
    for count in sorted(best):
        one = best[count]
        values = dict(zip(one.problem.names, one.values.tolist(), strict=True))
        found.setdefault(_key(one.problem), (one.problem, values))
    return [
        row
        for problem, values in found.values()
        if not problem.mirrored
        for row in _rows(problem, values, bench)
    ]


def _key(problem: Problem) -> tuple[object, ...]:
    return problem.model, problem.names, problem.inertia, problem.mirrored


def _rows(problem: Problem, values: Mapping[str, float], bench: Bench) -> list[dict[str, Any]]:
    """Return what the model says of the mechanism with the fitted `values`.

    To six digits, beyond which another seed finds others (5e-6 measured): another machine's last
    bits then hardly ever make of the same fit another mechanism with a hash of its own.
    """
    fitted = {name: float(f"{value:.6g}") for name, value in values.items()}
    table, model = problem.table, problem.model
    count = table.frequencies.shape[1]
    found = []
    for case, own in zip(table.cases, problem.at(fitted), strict=True):
        mechanism, pose = described(own, problem.inertia, case.mechanism)
        how = settings(model, count + SPARE, table=table.source, case=case.name, fitted=fitted)
        modes = bench.solve(model, mechanism, pose, count + SPARE)
        if not isinstance(modes, Failure):
            one = Case(IDENTIFIED, mechanism, pose, f"fitted to {table.source}")
            found += mode_rows(one, label(model), how, modes, count)
    return found
