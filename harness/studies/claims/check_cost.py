"""Checks of what the model costs: counted operations decide, seconds are quoted beside them.

Of finite elements no operations are counted: their seconds are quoted, and no verdict but that of
a theory slower than all of them hangs on these.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from harness.studies.claims.data import (
    CANNOT,
    FAILS,
    ONLY_IF,
    RULES,
    Finding,
    finding,
    reads,
)
from harness.studies.claims.facts import PAPER, Facts, Floats

RIVALS = {
    "saddle-point": "keeps its multipliers as unknowns",
    "null-space": "solves its constraints by their null space",
}


def _quartiles(values: Floats, unit: str) -> tuple[float, str]:
    """Return the median, and in words the quartiles."""
    low, middle, high = (float(v) for v in np.percentile(values, [25, 50, 75]))
    return middle, f"{low:.4g} to {high:.4g}{unit} (quartiles of {len(values)} rounds)"


def _ratios(times: Mapping[str, Floats]) -> dict[str, float]:
    """Return how many times as long as the theory each kind of finite elements takes."""
    own, *others = ((label, float(np.median(values))) for label, values in times.items())
    return {label: value / own[1] for label, value in others}


def _unless_slower(times: Mapping[str, Floats], verdict: str) -> str:
    """Return `verdict`, or that the theory saves nothing against any finite elements here."""
    if max(_ratios(times).values()) > 1:
        return verdict
    return f"{FAILS}: no finite elements here take longer than the theory"


@reads("fea_times")
def seconds(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Does a pose take the printed time? No agreement of two machines would be more than chance."""
    quantity = args["quantity"]
    label = list(facts.fea_times)[["theoretical model", "finite-element model"].index(quantity)]
    middle, uncertainty = _quartiles(facts.fea_times[label], " s")
    verdict = (
        f"{CANNOT}: no machine, program or problem size is printed; here it takes "
        f"{100 * middle / facts.printed.cost[quantity]:.2g} % of that"
    )
    verdict = _unless_slower(facts.fea_times, verdict)
    return Finding(f"{middle:.4g} s by {label}", uncertainty, verdict)


@reads("fea_times")
def saved(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Against which finite elements is as much saved? The printed ones are not known."""
    times, ratios = facts.fea_times, _ratios(facts.fea_times)
    needed = 1 / (1 - facts.printed.cost["cost saved"] / 100)
    words, bounds = [], []
    for label in ratios:
        rounds = min(len(times[PAPER.label]), len(times[label]))
        share = 100 * (1 - times[PAPER.label][:rounds] / times[label][:rounds])
        middle, quartiles = _quartiles(share, " %")
        words.append(f"{middle:.4g} % against {label}")
        bounds.append(quartiles if rounds > 1 else "timed once")
    # One digit: the next is the machine's.
    rough = ", ".join(f"{k} takes about {float(f'{v:.1g}'):g} times" for k, v in ratios.items())
    verdict = (
        f"{ONLY_IF} the finite elements take {needed:.2g} times as long as the theory: {rough}"
    )
    return Finding("; ".join(words), "; ".join(bounds), _unless_slower(times, verdict))


@reads("times")
def faster(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Does the model take clearly fewer operations than both ways with multipliers?"""
    own = facts.times["paper"]
    words, bounds, other = [], [], []
    for name, what in RIVALS.items():
        rival = facts.times[name]
        fewer = own.flops / rival.flops
        middle, quartiles = _quartiles(own.seconds / rival.seconds, "")
        words.append(
            f"{fewer:.2f} times the operations of the rival that {what} ({middle:.2f} times its "
            f"seconds, {own.solve / rival.solve:.2f} times those of its eigen-solution)"
        )
        bounds.append(f"counted; of the seconds {quartiles}")
        if fewer > RULES.clearly_fewer:
            other.append(what)
    slow = [what for what in RIVALS.values() if what not in other]
    otherwise = f"{FAILS}: it does not take clearly fewer than either way with multipliers"
    if slow:
        otherwise = (
            f"{ONLY_IF} the rival {' or '.join(slow)}: against one that {' or '.join(other)} it "
            f"does not take clearly fewer operations ({RULES.clearly_fewer:g} times or less)"
        )
    return finding(not other, "; ".join(words), "; ".join(bounds), otherwise)
