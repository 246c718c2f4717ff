"""The timing study as tables and a figure, beside what the paper claims."""

from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import scipy
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, ScalarFormatter

from analytic import Substructure
from analytic.kernel import compiled
from harness import published
from harness.cases import PRESETS
from harness.figures import COLOURS, MARKERS, figure_files
from harness.models import PAPER_ELEMENTS
from harness.precision.cost import ENDLESS, FEW, FLOOR, SLOW, YARDSTICK, Cost, Timing, growth
from harness.tables import Cell, Number, Table, table_files

MANY_MARKERS = (*MARKERS, "P", "X", "<", ">", "*", "p")
LARGE = 8
"""From this s on, growth is fitted a second time: below it, what does not grow dominates."""
DENSE = "substructure, dense"
TRADITIONAL = ("multipliers, null-space", "multipliers, saddle-point")


def cost_tables(cost: Cost) -> dict[str, Table]:
    """Return all tables by the stem of their files."""
    return {
        "cost-elements": elements_table(cost),
        "cost-growth": growth_table(cost),
        "cost-batches": batches_table(cost),
        "cost-claims": claims_table(cost),
    }


def cost_files(cost: Cost) -> dict[str, bytes]:
    """Return all tables and the figure as files to write."""
    return figure_files(cost_figure(cost), "cost") | table_files(cost_tables(cost))


def cost_sentences(cost: Cost) -> list[str]:
    """Return what a pose costs in large batches, and what multipliers cost beside the paper's."""
    lines = []
    size = max((t.size or 1 for t in cost.batches), default=0)
    exact = {t.model: t for t in cost.batches if t.size == size and t.model.endswith("exact")}
    if exact:
        each = "; ".join(
            f"{name.removesuffix(', exact')}: {np.median(timing.ratios):.1f} "
            f"({1e6 * np.median(timing.seconds):.0f} microseconds)"
            for name, timing in exact.items()
        )
        lines.append(
            f"Exact Euler-Bernoulli frequencies, {size} random poses a call, take a pose, in 6x6 "
            f"numpy.linalg.eigh calls of the same run: {each}."
        )
    at_three = {t.model: t for t in cost.elements if t.size == PAPER_ELEMENTS}
    own = at_three[DENSE]
    times = "; ".join(
        f"{model}: {np.median(at_three[model].ratios / own.ratios):.2f}" for model in TRADITIONAL
    )
    lines.append(
        f"At s = {PAPER_ELEMENTS}, in times of the paper's formulation in the same round: {times}."
    )
    return lines


def elements_table(cost: Cost) -> Table:
    """Return seconds, dofs and ratios of one pose against the number of elements."""
    rows: list[tuple[Cell, ...]] = [
        (
            timing.model,
            "exact" if timing.size is None else timing.size,
            "-" if timing.dofs is None else timing.dofs,
            *_quartiles(1e3 * timing.seconds, 3),
            "-" if timing.solving is None else Number(1e3 * timing.solving, 3),
            *_quartiles(timing.ratios, 2)[1:],
        )
        for timing in cost.elements
    ]
    times = ("min [ms]", "q1 [ms]", "median [ms]", "q3 [ms]", "solving [ms]")
    columns = ("Model", "s", "dofs", *times, "ratio q1", "ratio", "ratio q3")
    left_out = tuple(f"{model}: {why.strip('; ')}" for model, why in cost.left_out.items())
    notes = (
        f"ratio: to {YARDSTICK}, {1e3 * np.median(cost.yardstick.seconds):.3f} ms here",
        "one pose, six modes with shapes (condensed: frequencies alone), matrices included; "
        "solving: the eigen-solution's part of it",
        "dofs: coordinates solved for, and multipliers where they are kept; condensed: none are "
        "assembled",
        *_circumstances(cost),
        *left_out,
    )
    return Table("Cost of one pose against the number of elements", columns, tuple(rows), notes)


def growth_table(cost: Cost) -> Table:
    """Return the growth exponents over all s, and over large s."""
    large = {fit.model: fit for fit in growth(cost.elements, LARGE)}
    rows: list[tuple[Cell, ...]] = []
    for fit in growth(cost.elements):
        row: tuple[Cell, ...] = (fit.model, _range(fit.sizes))
        row += (Number(fit.exponent, 2), Number(fit.error, 2))
        if fit.model in large:
            tail = large[fit.model]
            row += (_range(tail.sizes), Number(tail.exponent, 2), Number(tail.error, 2))
        else:
            row += ("-", "-", "-")
        rows.append(row)
    columns = ("Model", "s", "exponent", "std. error", "large s", "exponent", "std. error")
    notes = ("median seconds ~ s^exponent, least squares on logarithms; three sizes at least",)
    return Table("Growth of cost with the number of elements", columns, tuple(rows), notes)


def batches_table(cost: Cost) -> Table:
    """Return the cost a pose of `condensed_frequencies` against the number of poses a call."""
    yardstick = np.median(cost.yardstick.seconds)
    rows: list[tuple[Cell, ...]] = [
        (
            timing.model,
            timing.size or 1,
            *_quartiles(1e6 * timing.seconds, 2),
            *_quartiles(timing.ratios, 2)[1:],
            Number(float(np.median(timing.seconds) / yardstick), 4),
        )
        for timing in cost.batches
    ]
    times = ("min [us]", "q1 [us]", "median [us]", "q3 [us]")
    calls = ("6x6 eigh q1", "6x6 eigh", "6x6 eigh q3")
    columns = ("Model", "poses a call", *times, *calls, "ratio")
    notes = (
        f"all a pose; 6x6 eigh: ratio to {FLOOR}, "
        f"{1e6 * np.median(cost.floor.seconds):.2f} us here",
        f"ratio: to {YARDSTICK}",
        *_circumstances(cost),
    )
    return Table("Cost of a pose against the number of poses a call", columns, tuple(rows), notes)


def claims_table(cost: Cost) -> Table:
    """Return what the paper claims next to what this run measured."""
    said = published.cost()
    at_three = {t.model: t for t in cost.elements if t.size == PAPER_ELEMENTS}
    own = at_three[DENSE]
    rows: list[tuple[Cell, ...]] = [
        _seconds("theoretical model", said["theoretical model"], f"{DENSE}, s=3", own)
    ]
    fea = cost.stand_in
    if fea is not None:
        rows.append(_seconds("finite-element model", said["finite-element model"], fea.model, fea))
        rows.append(_saved(said["cost saved"], fea.model, own, fea))
    for model in TRADITIONAL:
        rows.append(_seconds(model, None, f"{model}, s=3", at_three[model]))
        rows.append(_saved(None, model, own, at_three[model]))
    first, last = _ends([t.size for t in cost.elements if t.model == DENSE])
    for name in ("case1", "case2"):
        fewer = published.figure3()[name, 1, 1] - published.table1()[name, "Error (%)"][0]
        rows.append((f"f1 of {name}, s=1 to s=3", "%", Number(fewer, 2), *_change(name, 1, 3, 1)))
        for mode in (1, 6):
            what = f"f{mode} of {name}, s={first} to s={last}"
            rows.append((what, "%", "-", *_change(name, first, last, mode)))
    columns = ("Claim", "Unit", "Paper", "Here", "Ratio", "What was measured")
    notes = (
        "the paper compares with finite elements (ANSYS) alone and says neither on what machine "
        "nor what the times include; it gives no time with multipliers",
        "f1: the paper's error falls by so many points (Fig. 3's text, Table I); here the "
        "frequency falls by so many percent; f6 shows what one element does to a higher mode",
        f"ratio: to {YARDSTICK}",
        *_circumstances(cost),
    )
    return Table("What the paper claims, and what was measured", columns, tuple(rows), notes)


def _quartiles(values: np.ndarray, digits: int) -> tuple[Number, ...]:
    """Return minimum, lower quartile, median and upper quartile."""
    return tuple(Number(float(v), digits) for v in np.percentile(values, [0, 25, 50, 75]))


def _range(sizes: Sequence[int]) -> str:
    return f"{sizes[0]}-{sizes[-1]}"


def _ends(sizes: Sequence[int | None]) -> tuple[int, int]:
    known = [size for size in sizes if size is not None]
    return known[0], known[-1]


def _circumstances(cost: Cost) -> tuple[str, ...]:
    loop = "condensed, compiled: by numba" if compiled() else "numba is not installed"
    return (
        f"condensed: plain numpy; {loop}",
        f"{PRESETS['case2'].name}, {cost.repeats} rounds of everything ({FEW} of what takes over "
        f"{SLOW:g} s, 1 over {ENDLESS:g} s), one BLAS thread",
        f"numpy {np.__version__}, scipy {scipy.__version__}",
    )


def _seconds(claim: str, said: float | None, what: str, timing: Timing) -> tuple[Cell, ...]:
    printed: Cell = "-" if said is None else Number(said, 2)
    measured = Number(float(np.median(timing.seconds)), 4)
    return (claim, "s", printed, measured, Number(float(np.median(timing.ratios)), 1), what)


def _saved(said: float | None, what: str, own: Timing, rival: Timing) -> tuple[Cell, ...]:
    printed: Cell = "-" if said is None else Number(said, 2)
    rounds = min(len(own.seconds), len(rival.seconds))
    saved = 100 * np.median(1 - own.seconds[:rounds] / rival.seconds[:rounds])
    claim = f"cost saved against {what}"
    return (claim, "%", printed, Number(float(saved), 2), "-", f"{DENSE}, s=3")


def _change(name: str, fewer: int, more: int, mode: int) -> tuple[Cell, ...]:
    case = PRESETS[name]
    coarse, fine = (
        Substructure(s).modes(case.mechanism, case.pose, 6).frequencies[mode - 1]
        for s in (fewer, more)
    )
    fall = 100 * (coarse - fine) / fine
    return (Number(float(fall), 4), "-", f"{DENSE}, frequency's fall")


def cost_figure(cost: Cost) -> Figure:
    """Return (a) one pose against elements and (b) a pose against batch size, both log-log.

    Lines join medians and bands hold the middle half; simulators are dashed and hollow.
    """
    figure = Figure(figsize=(11.5, 5.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    simulators = 0
    exact = [timing for timing in cost.elements if timing.size is None]
    names = dict.fromkeys(timing.model for timing in cost.elements if timing.size is not None)
    for k, name in enumerate(names):
        ours = name.startswith(("substructure", "multipliers", "condensed"))
        style: dict[str, Any] = {"ls": "-"} if ours else {"ls": "--", "mfc": "none"}
        number = k if ours else simulators
        simulators += not ours
        _curve(left, [t for t in cost.elements if t.model == name and t.size], number, name, style)
    for timing, dots in zip(exact, (":", "-.", "--"), strict=False):
        level, label = float(np.median(timing.ratios)), f"{timing.model}, exact"
        left.axhline(level, color="0.3", ls=dots, lw=1.2, label=label)
    left.set_xlabel("number of elements $s$")
    left.set_ylabel("time of one pose / yardstick")
    left.set_title(f"(a) yardstick: {YARDSTICK}", fontsize=9)
    _ticks(left, sorted({t.size for t in cost.elements if t.size}), 2)
    for k, name in enumerate(dict.fromkeys(timing.model for timing in cost.batches)):
        _curve(right, [t for t in cost.batches if t.model == name], k, name, {"ls": "-"})
    right.set_xlabel("poses a call")
    right.set_ylabel("time a pose / one 6x6 eigh")
    right.set_title(f"(b) yardstick: {FLOOR}", fontsize=9)
    right.set_xscale("log")
    for axes in (left, right):
        axes.set_yscale("log")
        axes.grid(alpha=0.25)
        # Below the axes: inside there is no corner that every run leaves free.
        below = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.13)}
        axes.legend(fontsize=8, ncols=3, frameon=False, **below)
    return figure


def _curve(
    axes: mpl.axes.Axes, timings: Sequence[Timing], k: int, label: str, style: dict[str, Any]
) -> None:
    sizes = [timing.size or 1 for timing in timings]
    low, middle, high = (
        np.array([np.percentile(timing.ratios, q) for timing in timings]) for q in (25, 50, 75)
    )
    colour, marker = COLOURS[k % len(COLOURS)], MANY_MARKERS[k % len(MANY_MARKERS)]
    axes.plot(sizes, middle, color=colour, marker=marker, ms=5, lw=1.2, label=label, **style)
    axes.fill_between(sizes, low, high, color=colour, alpha=0.15, lw=0)


def _ticks(axes: mpl.axes.Axes, sizes: Sequence[int], base: int) -> None:
    axes.set_xscale("log", base=base)
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xticks(sizes)
