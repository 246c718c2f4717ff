"""Checks of what the model costs, by counted work and the time of the eigen-solution at once.

Neither holds what an interpreter adds, so that a compiled language changes no verdict. A claim
that says cheaper and not by how much is judged by the sign of the difference.
"""

import numpy as np

from harness.signatures import Array
from harness.studies.claims.facts import PAPER, Args, Facts, Outcome, outcome

RIVALS = {
    "saddle-point": "keeps its multipliers as unknowns",
    "null-space": "solves its constraints by their null space",
}


def _quartiles(values: Array, unit: str) -> tuple[float, str]:
    """Return the median, and in words the quartiles."""
    low, middle, high = np.percentile(values, [25, 50, 75]).tolist()
    return middle, f"{low:.4g} to {high:.4g}{unit} (quartiles of {len(values)} rounds)"


def _saving(facts: Facts) -> str:
    """Return "slower" unless the theory saves against one kind of finite elements.

    Seconds, those of the eigen-solution, and coordinates.
    """
    own, *others = facts.fea_times.values()
    saving = any(all(np.median(ratio) < 1 for ratio in own.over(rival)) for rival in others)
    return "otherwise" if saving else "slower"


def seconds(facts: Facts, args: Args) -> Outcome:
    """Does a pose take the printed time? No agreement of two machines would be more than chance."""
    quantity = args["quantity"]
    k = ["theoretical model", "finite-element model"].index(quantity)
    label, spent = list(facts.fea_times.items())[k]
    middle, quartiles = _quartiles(spent.seconds, " s")
    said = {"share": 100 * middle / facts.printed.cost[quantity], "solve": np.median(spent.solves)}
    said |= {"label": label, "middle": middle, "quartiles": quartiles, "work": spent.work}
    return outcome(False, _saving(facts), **said)


def saved(facts: Facts, args: Args) -> Outcome:
    """Against which finite elements is as much saved? The printed ones are not known."""
    own, words, bounds, rough = facts.fea_times[PAPER.label], [], [], []
    for label, rival in list(facts.fea_times.items())[1:]:
        whole, solve, work = own.over(rival)
        middle, quartiles = _quartiles(100 * (1 - whole), " %")
        words.append(
            f"{middle:.4g} % against {label} ({100 * (1 - np.median(solve)):.4g} % of the seconds "
            f"of its eigen-solution, which has {1 / work:.3g} times the coordinates)"
        )
        bounds.append(quartiles if len(whole) > 1 else "timed once")
        # One digit: the next is the machine's.
        times = float(f"{np.median(rival.seconds) / np.median(own.seconds):.1g}")
        rough.append(f"{label} takes about {times:g} times")
    needed = 1 / (1 - facts.printed.cost["cost saved"] / 100)
    said = {"words": "; ".join(words), "bounds": "; ".join(bounds), "rough": ", ".join(rough)}
    return outcome(False, _saving(facts), needed=needed, **said)


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
    said = {"words": f"at s = {sizes[0]} to {sizes[-1]}, {'; '.join(words)}"}
    otherwise = "neither" if all(against) else "otherwise"
    return outcome(not where, otherwise, where=" and ".join(where), **said)
