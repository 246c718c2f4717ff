"""Checks of what the model costs, by counted work and the time of the eigen-solution at once.

Neither holds what an interpreter adds, so that a compiled language changes no verdict. A claim
that says cheaper and not by how much is judged by the sign of the difference.
"""

from collections.abc import Mapping

import numpy as np

from harness.signatures import Array
from harness.studies.claims.data import Args, Outcome, outcome
from harness.studies.claims.facts import PAPER, Facts, Spent

RIVALS = {
    "saddle-point": "keeps its multipliers as unknowns",
    "null-space": "solves its constraints by their null space",
}


def _quartiles(values: Array, unit: str) -> tuple[float, str]:
    """Return the median, and in words the quartiles."""
    low, middle, high = (float(v) for v in np.percentile(values, [25, 50, 75]))
    return middle, f"{low:.4g} to {high:.4g}{unit} (quartiles of {len(values)} rounds)"


def _ratios(times: Mapping[str, Spent]) -> tuple[dict[str, float], str]:
    """Return how many times as long as the theory each kind of finite elements takes.

    And which verdict follows: "slower" unless the theory saves seconds, those of the eigen-solution
    and coordinates against one of them.
    """
    own, *others = times.values()
    saving = any(all(np.median(ratio) < 1 for ratio in own.over(rival)) for rival in others)
    middle = {label: float(np.median(spent.seconds)) for label, spent in times.items()}
    first, *rest = middle
    ratios = {label: middle[label] / middle[first] for label in rest}
    return ratios, "otherwise" if saving else "slower"


def seconds(facts: Facts, args: Args) -> Outcome:
    """Does a pose take the printed time? No agreement of two machines would be more than chance."""
    times, quantity = facts.fea_times, args["quantity"]
    label = list(times)[["theoretical model", "finite-element model"].index(quantity)]
    spent = times[label]
    middle, quartiles = _quartiles(spent.seconds, " s")
    share = 100 * middle / facts.printed.cost[quantity]
    said = {"label": label, "quartiles": quartiles, "share": share, "work": spent.work}
    solve = float(np.median(spent.solves))
    return outcome(False, _ratios(times)[1], middle=middle, solve=solve, **said)


def saved(facts: Facts, args: Args) -> Outcome:
    """Against which finite elements is as much saved? The printed ones are not known."""
    times = facts.fea_times
    ratios, verdict = _ratios(times)
    words, bounds = [], []
    for label in ratios:
        whole, solve, work = times[PAPER.label].over(times[label])
        middle, quartiles = _quartiles(100 * (1 - whole), " %")
        words.append(
            f"{middle:.4g} % against {label} ({100 * (1 - np.median(solve)):.4g} % of the seconds "
            f"of its eigen-solution, which has {1 / work:.3g} times the coordinates)"
        )
        bounds.append(quartiles if len(whole) > 1 else "timed once")
    # One digit: the next is the machine's.
    rough = ", ".join(f"{k} takes about {float(f'{v:.1g}'):g} times" for k, v in ratios.items())
    needed = 1 / (1 - facts.printed.cost["cost saved"] / 100)
    return outcome(
        False, verdict, words="; ".join(words), bounds="; ".join(bounds), needed=needed, rough=rough
    )


def faster(facts: Facts, args: Args) -> Outcome:
    """Does the model take less than both ways with multipliers, at every number of elements?"""
    words, where, against = [], [], []
    sizes = np.array(list(facts.times["paper"]))
    for name, what in RIVALS.items():
        each = [facts.times["paper"][s].over(rival) for s, rival in facts.times[name].items()]
        work = np.array([fewer for _, _, fewer in each])
        low, middle, high = np.transpose([np.percentile(s, [25, 50, 75]) for _, s, _ in each])
        # Seconds speak where their quartiles are on one side; operations always do.
        cheaper, dearer = (work < 1) & (low <= 1), (work >= 1) & (high >= 1)
        against.append(dearer.all())
        words.append(
            f"{work.min():.2f} to {work.max():.2f} times the operations of the rival that {what}, "
            f"{middle.min():.2f} to {middle.max():.2f} times the seconds of its eigen-solution"
        )
        if not cheaper.all():
            at = ", ".join(map(str, sizes[cheaper]))
            where.append(f"the rival that {what} " + (f"has s = {at}" if at else "is left out"))
    return outcome(
        not where,
        "neither" if all(against) else "otherwise",
        words=f"at s = {sizes[0]} to {sizes[-1]}, " + "; ".join(words),
        where=" and ".join(where),
    )
