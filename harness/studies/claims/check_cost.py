"""Checks of what the model costs: counted operations decide, seconds are quoted beside them.

Of finite elements no operations are counted: their seconds are quoted, and no verdict but that of
a theory slower than all of them hangs on these.
"""

from collections.abc import Mapping

import numpy as np

from harness.studies.claims.data import RULES, Args, Outcome, outcome, reads
from harness.studies.claims.facts import PAPER, Facts, Floats

RIVALS = {
    "saddle-point": "keeps its multipliers as unknowns",
    "null-space": "solves its constraints by their null space",
}


def _quartiles(values: Floats, unit: str) -> tuple[float, str]:
    """Return the median, and in words the quartiles."""
    low, middle, high = (float(v) for v in np.percentile(values, [25, 50, 75]))
    return middle, f"{low:.4g} to {high:.4g}{unit} (quartiles of {len(values)} rounds)"


def _ratios(times: Mapping[str, Floats]) -> tuple[dict[str, float], str]:
    """Return how many times as long as the theory each kind of finite elements takes.

    And which verdict follows: another if the theory saves nothing against any of them.
    """
    own, *others = ((label, float(np.median(values))) for label, values in times.items())
    ratios = {label: value / own[1] for label, value in others}
    return ratios, "otherwise" if max(ratios.values()) > 1 else "slower"


@reads("fea_times")
def seconds(facts: Facts, args: Args) -> Outcome:
    """Does a pose take the printed time? No agreement of two machines would be more than chance."""
    times, quantity = facts.fea_times, args["quantity"]
    label = list(times)[["theoretical model", "finite-element model"].index(quantity)]
    middle, quartiles = _quartiles(times[label], " s")
    share = 100 * middle / facts.printed.cost[quantity]
    verdict = _ratios(times)[1]
    return outcome(False, verdict, middle=middle, label=label, quartiles=quartiles, share=share)


@reads("fea_times")
def saved(facts: Facts, args: Args) -> Outcome:
    """Against which finite elements is as much saved? The printed ones are not known."""
    times = facts.fea_times
    ratios, verdict = _ratios(times)
    words, bounds = [], []
    for label in ratios:
        rounds = min(len(times[PAPER.label]), len(times[label]))
        share = 100 * (1 - times[PAPER.label][:rounds] / times[label][:rounds])
        middle, quartiles = _quartiles(share, " %")
        words.append(f"{middle:.4g} % against {label}")
        bounds.append(quartiles if rounds > 1 else "timed once")
    # One digit: the next is the machine's.
    rough = ", ".join(f"{k} takes about {float(f'{v:.1g}'):g} times" for k, v in ratios.items())
    needed = 1 / (1 - facts.printed.cost["cost saved"] / 100)
    return outcome(
        False, verdict, words="; ".join(words), bounds="; ".join(bounds), needed=needed, rough=rough
    )


@reads("times")
def faster(facts: Facts, args: Args) -> Outcome:
    """Does the model take clearly fewer operations than both ways with multipliers?"""
    own, words, bounds, other = facts.times["paper"], [], [], []
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
    return outcome(
        not other,
        "otherwise" if slow else "neither",
        words="; ".join(words),
        bounds="; ".join(bounds),
        slow=" or ".join(slow),
        other=" or ".join(other),
    )
