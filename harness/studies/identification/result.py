"""What an identification says: tables, sentences, a figure, and mechanisms for the history."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, islice
from math import floor, log10
from typing import Any

import numpy as np
from scipy import stats

from harness.bench import SPARE, Bench, label
from harness.case import Case
from harness.compare import cell, cells
from harness.result import Result
from harness.rows import mode_rows, settings
from harness.signatures import Figure
from harness.studies.identification.estimate import LEVEL, PINNED, Fit, Reading
from harness.studies.identification.problem import described
from harness.tables import Cell, Number, Table
from harness.workers import Failure

SHOWN, KEPT = 3, 12
"""Readings shown, and kept as numbers, for each number of free parameters, with either frames."""
ALIKE = 2
"""Readings whose AICc differs by less are equally good."""
MIRRORED = (
    "mirrored frames: a slip and no mechanism: limbs of the right length that lean from the "
    "vertical to the wrong side"
)
LOOSE = 0.5
VERDICTS = {0.05: "pins it down", LOOSE: "knows it loosely", np.inf: "leaves it open"}
"""What is said of a deviation below each of these."""
IDENTIFIED = "identified"
"""The case in a row: a fitted mechanism is not that of the table's case, which is in `settings`."""
BASE = "base_radius_mm"
PERCENT = f"{100 * LEVEL:.0f} %"


@dataclass(frozen=True)
class Identification(Result):
    """What a table of frequencies says of the mechanism that it belongs to.

    Attributes: `fits` of the parameters with intervals, one for each kind of frames; `readings`,
    best first; `kept`, rows of the history.
    """

    fits: tuple[Fit, ...]
    readings: tuple[Reading, ...]
    kept: tuple[dict[str, Any], ...]

    def rows(self) -> list[dict[str, Any]]:
        """Return what the models say of the fitted mechanisms."""
        return list(self.kept)

    def records(self) -> Iterator[dict[str, Any]]:
        """Return one row a fit or reading and parameter, in the unit of the parameter's name.

        Ends of 95 % intervals of the parameter alone, and of all together; NaN where none is known.
        """
        for rank, one in [*((1, fit) for fit in self.fits), *best(self.readings, KEPT)]:
            problem, fitted = one.problem, isinstance(one, Fit)
            about = {
                "table": problem.table.source, "model": label(problem.model),
                "inertia": problem.inertia, "frames": problem.frames, "free": len(problem.names),
                "kind": "fit" if fitted else "reading", "rank": rank, "rms_percent": 100 * one.rms,
                "worst_percent": one.worst, "aicc": np.nan if fitted else one.criterion,
            }  # fmt: skip
            for k, (name, value) in enumerate(one.fitted.items()):
                yield about | {"parameter": name, "value": value} | one.ends(k)
            if not one.fitted:
                yield about

    def tables(self) -> dict[str, Table]:
        """Return readings, parameters, what is left, and what the table pins down."""
        found = {"": readings_table(self.readings)} if self.readings else {}
        found["-parameters"] = parameters_table(self.fits)
        found["-residuals"] = residuals_table(self.fits)
        one = self.fits[-1]
        if one.problem.whole:
            found["-directions"] = directions_table(one)
        if one.named:
            found["-quantities"] = quantities_table(one)
        return found

    def figures(self) -> dict[str, Figure]:
        """Return the profiles of every parameter, and below them what the fits leave."""
        from harness.studies.identification.picture import profile_figure

        return {"": profile_figure(self.fits)}

    def sentences(self) -> list[str]:
        """Return what the fits and readings say; nothing of what was not asked for."""
        fits, ranked = self.fits, self.readings
        lines = _pinned(fits[-1]) if fits[-1].named else _known(fits[-1])
        if ranked:
            most = max(len(reading.x) for reading in ranked)
            lines.append(
                f"Of {len(ranked)} readings of {ranked[0].problem.table.source}, each with at most "
                f"{most} free parameters, {closest_note(ranked)}."
            )
        lines += _one_free(ranked)
        with_base = [one for one in fits if BASE in one.problem.names]
        return lines + (_lean(*with_base) if len(with_base) == 2 else [])


def best(ranked: Sequence[Reading], most: int) -> Iterator[tuple[int, Reading]]:
    """Yield rank and reading, the best of each number of free parameters with either frames."""
    order = sorted(ranked, key=lambda r: (len(r.x), r.problem.mirrored, r.rms))
    for _, group in groupby(order, key=lambda r: (len(r.x), r.problem.mirrored)):
        yield from enumerate(islice(group, most), start=1)


def readings_table(ranked: Sequence[Reading]) -> Table:
    """Return the best readings of every number of free parameters, and what they miss [%]."""
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (len(r.x), r.problem.frames, rank, r.problem.theory, str(r), Number(100 * r.rms, 2),
         Number(r.worst, 2), cell(r.criterion, 1, none="too few values"))
        for rank, r in best(ranked, SHOWN)
    )  # fmt: skip
    columns = ("Free", "Frames", "Rank", "Model", "Fitted", "rms [%]", "worst [%]", "AICc")
    table, plainest = ranked[0].problem.table, simplest(ranked)
    notes = (
        f"of {table.source}; what is not named is as in {', '.join(c.name for c in table.cases)}",
        f"{len(ranked)} readings: every choice of so many candidates, under every model; rms over "
        "different values: a repeated mode counts once; *: at a bound",
        f"AICc: Akaike's criterion for few values; differences below {ALIKE} mean nothing. Fewest "
        f"parameters among the best: {plainest.problem.label}, {plainest}",
        closest_note(ranked),
        *((MIRRORED,) if any(r.problem.mirrored for r in ranked) else ()),
    )
    return Table("Readings ranked by free parameters", columns, rows, notes)


def simplest(ranked: Sequence[Reading]) -> Reading:
    """Return, of all readings as good as the best by AICc, that of the fewest parameters."""
    least = np.nanmin([r.criterion for r in ranked] + [np.inf])
    good = [r for r in ranked if r.criterion <= least + ALIKE] or ranked
    return min(good, key=lambda r: (len(r.x), r.rms))


def closest_note(ranked: Sequence[Reading]) -> str:
    """Return in words how near the closest reading comes to all values."""
    table, closest = ranked[0].problem.table, min(r.worst for r in ranked)
    rounding = 50 * (table.step / table.frequencies).max()
    if closest <= rounding:
        return "the closest meets every value to its last digit"
    return (
        f"none meets all {table.frequencies.size} values: the closest is {closest:.2f} % off "
        f"somewhere, where rounding explains {rounding:.3f} %"
    )


def parameters_table(fits: Sequence[Fit]) -> Table:
    """Return fitted parameters with their intervals, and whether what was given lies inside."""
    rows: list[tuple[Cell, ...]] = []
    notes = []
    for one in fits:
        name = one.problem.label
        for parameter, value, given, alone, together, opened in one.intervals():
            ends = [
                f"none ({_number(end)})" if none else _number(end)
                for end, none in zip(together, opened, strict=True)
            ]
            lies = "inside" if together[0] <= given <= together[1] else "outside"
            rows.append((name, parameter, _number(value), *map(_number, alone), *ends,
                         _number(given), lies))  # fmt: skip
        source = "as given"
        if one.assumed is None:
            source = f"from the residuals themselves ({one.freedom} to spare)"
        elif one.assumed == one.problem.table.rounding:
            source = "from the rounding of the table"
        notes.append(
            f"{name}: rms {100 * one.rms:.2f} %, noise {100 * one.noise:.3g} % a value, {source}; "
            f"{one.reached} starts met at this minimum"
        )
    notes += [
        f"profile likelihood: 'alone' holds each true value in {PERCENT} of tables, 'together' all "
        f"of them at once in at least {PERCENT}",
        "none (bound): the parameter's bound came first; the table sets no end before it",
    ]
    columns = ("Model", "Parameter", "Fitted", "alone: from", "to", "together: from", "to",
               "Given", "Given lies")  # fmt: skip
    title = f"Parameters of {fits[0].problem.table.source}"
    return Table(title, columns, tuple(rows), tuple(notes))


def _number(value: float) -> Number:
    """Return a number with four digits, but at most four decimals."""
    digits = max(0, 3 - floor(log10(abs(value)))) if value else 3
    return Number(float(value), min(digits, 4))


def residuals_table(fits: Sequence[Fit]) -> Table:
    """Return what each fit leaves, by case and mode [%]."""
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (one.problem.label, case.name, *cells(100 * error, signed=True))
        for one in fits
        for case, error in zip(one.problem.table.cases, one.error, strict=True)
    )
    columns = ("Model", "Case", *(f"f{i} [%]" for i in range(1, fits[0].error.shape[1] + 1)))
    return Table("What the fits leave: f over the table's, less 1", columns, rows)


def directions_table(one: Fit) -> Table:
    """Return the products of powers, and how well each is known."""
    always = ", whatever the table; they tell neither scale nor E and rho raised alike"
    rows = tuple(
        (str(d), cell(100 * d.deviation, none="infinite") if not 10 <= d.deviation < np.inf
         else "over 1000", _verdict(d.deviation))
        for d in one.directions
    )  # fmt: skip
    notes = (
        f"{one.problem.label}; singular vectors of d ln f / d ln p at the fit, powers below 0.1 "
        "left out; theta and phi: tilt and azimuth themselves",
        f"infinite: frequencies do not change at all along these{always if one.named else ''}",
    )
    columns = ("Product of powers", "1 sigma [%]", "The table")
    return Table("What the table pins down, and what not", columns, rows, notes)


def quantities_table(one: Fit) -> Table:
    """Return the named combinations, and how well each is known."""
    rows = tuple(
        (name, Number(value, 4), Number(100 * before, 1), Number(100 * after, 1), _verdict(after))
        for name, (value, before, after) in one.quantities.items()
    )
    notes = (
        f"{one.problem.label}; E and rho as given, all else free within its bounds",
        "L: a limb without tilt; m, Jz: the platform's mass and polar moment of inertia",
    )
    columns = ("Combination", "Value", "by bounds, 1 sigma [%]", "with the table [%]", "The table")
    return Table("Named combinations", columns, rows, notes)


def _verdict(deviation: float) -> str:
    return next((said for most, said in VERDICTS.items() if deviation < most), "cannot see it")


def _pinned(one: Fit) -> list[str]:
    """Return d / L^2 with its interval, beside what the given parameters make it."""
    value, _, deviation = one.quantities[PINNED]
    likely = stats.t(one.freedom) if one.assumed is None else stats.norm
    spread = np.exp(likely.ppf((1 + LEVEL) / 2) * deviation)
    stated = (one.problem.groups(base)[PINNED].item() for base in one.problem.at({}))
    given = " and ".join(dict.fromkeys(f"{own:.4f}" for own in stated))
    return [
        f"By {one.problem.table.source}, the limbs' d/L^2 is {value:.4f} 1/m ({value / spread:.4f} "
        f"to {value * spread:.4f} at {PERCENT}, E and rho as given); the given parameters make it "
        f"{given} 1/m."
    ]


def _known(one: Fit) -> list[str]:
    """Return every parameter with its interval, and what is left open."""
    words = [
        f"{name} is {_number(value)} ({_number(alone[0])} to {_number(alone[1])} at {PERCENT}; "
        f"{_number(given)} given)"
        for name, value, given, alone, _, opened in one.intervals()
        if not all(opened)
    ]
    lines = [f"By {one.problem.table.source}, {', '.join(words)}."] if words else []
    return lines + [
        f"The table leaves {direction} open: along it the fitted frequencies change too little."
        for direction in one.left
        if direction.deviation >= LOOSE
    ]


def _one_free(ranked: Sequence[Reading]) -> list[str]:
    """Return the best reading with one free parameter, and that with the other frames."""
    found = sorted((r for _, r in best(ranked, 1) if len(r.x) == 1), key=lambda r: r.rms)
    words = [
        f"{r.problem.label}, {r} (rms {100 * r.rms:.2f} %, at most {r.worst:.2f} % off)"
        for r in found
    ]
    if len(words) == 2:
        frames = "mirrored" if found[1].problem.mirrored else "as stated"
        words[1] = f"with frames {frames} it is {words[1]}"
    return [f"The best reading with one free parameter is {'; '.join(words)}."] if words else []


def _lean(stated: Fit, mirrored: Fit) -> list[str]:
    """Return what both frames make of the base's radius, and whether the table prefers one."""
    problem, table, both = stated.problem, stated.problem.table, (stated, mirrored)
    k = problem.names.index(BASE)
    words = [f"{one.values[k]:.0f} mm ({one.alone[k, 0]:.0f} to {one.alone[k, 1]:.0f})"
             for one in both]  # fmt: skip
    radius = problem.known[0]["platform_radius_mm"].value
    lean = "outwards" if stated.values[k] < radius else "inwards"
    # A fit below the rounding is as good as any other there.
    rms = [max(one.rms, table.rounding, 1e-150) for one in both]
    better = 2 * table.count * np.log(rms[0] / rms[1])
    verdict = "The table does not tell the two apart"
    if abs(better) > ALIKE:
        verdict = f"The table prefers {'mirrored' if better > 0 else 'stated'} frames"
    return [
        f"Fitted to {table.source}: with frames as stated, the base's radius is {words[0]} at "
        f"{PERCENT}, where {problem.given[k]:.0f} mm is given and the platform has "
        f"{radius:.0f} mm: limbs that lean {lean}; with mirrored frames, a slip and no mechanism, "
        f"it is {words[1]}. {verdict} (rms {100 * rms[0]:.2f} and {100 * rms[1]:.2f} %)."
    ]


def solved(fits: Sequence[Fit], ranked: Sequence[Reading], bench: Bench) -> list[dict[str, Any]]:
    """Return rows for the history: what the models say of what was fitted.

    Of every fit, and of the best reading of each number of free parameters; those with mirrored
    frames left out, for they are no mechanism. To six digits of the parameters, beyond which
    another seed finds others (5e-6 measured): another machine's last bits then hardly ever make of
    the same fit another mechanism with a hash of its own.
    """
    found: dict[tuple[object, ...], Reading] = {}
    for one in (*fits, *(reading for _, reading in best(ranked, 1))):
        if one.fitted and not one.problem.mirrored:
            found.setdefault((one.problem.model, one.problem.names, one.problem.inertia), one)
    rows = []
    for one in found.values():
        problem, table, model = one.problem, one.problem.table, one.problem.model
        values = {name: float(f"{value:.6g}") for name, value in one.fitted.items()}
        count, form = table.frequencies.shape[1], problem.form if problem.regular else None
        for case, own in zip(table.cases, problem.at(values), strict=True):
            mechanism, pose = described(case, own, form)
            how = settings(model, count + SPARE, table=table.source, case=case.name, fitted=values)
            modes = bench.solve(model, mechanism, pose, count + SPARE)
            if not isinstance(modes, Failure):
                there = Case(IDENTIFIED, mechanism, pose, f"fitted to {table.source}")
                rows += mode_rows(there, label(model), how, modes, count)
    return rows
