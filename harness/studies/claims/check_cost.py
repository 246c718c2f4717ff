"""Checks of what the model costs: medians of rounds in turns, with their quartiles."""

import numpy as np

from harness.studies.claims.check_printed import EDGE
from harness.studies.claims.data import CANNOT, FAILS, HOLDS, ONLY_IF, Claim, Finding, Rules, reads
from harness.studies.claims.facts import PAPER, Facts, FeaTimes, Floats


def _quartiles(values: Floats) -> tuple[float, float, float]:
    low, middle, high = (float(v) for v in np.percentile(values, [25, 50, 75]))
    return low, middle, high


def _between(low: float, high: float, unit: str, rounds: int) -> str:
    return f"{low:.4g} to {high:.4g}{unit} (quartiles of {rounds} rounds)"


@reads("fea_times")
def seconds(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Does a pose take the printed time? No agreement of two machines would be more than chance."""
    times, quantity = facts.fea_times, claim.args["quantity"]
    label, values = {
        "theoretical model": (PAPER.label, times.own),
        "finite-element model": next(iter(times.fea.items())),
    }[quantity]
    low, middle, high = _quartiles(values)
    measured = f"{middle:.4g} s by {label}"
    uncertainty = _between(low, high, " s", len(values))
    verdict = (
        f"{CANNOT}: no machine, program or problem size is printed; here it takes "
        f"{100 * middle / facts.printed.cost[quantity]:.2g} % of that"
    )
    return Finding(measured, uncertainty, _unless_slower(times, verdict))


def _ratios(times: FeaTimes) -> dict[str, float]:
    """Return how many times as long as the theory each kind of finite elements takes."""
    own = np.median(times.own)
    return {label: float(np.median(values) / own) for label, values in times.fea.items()}


def _unless_slower(times: FeaTimes, verdict: str) -> str:
    """Return `verdict`, or that the theory saves nothing against any finite elements here."""
    if max(_ratios(times).values()) > 1:
        return verdict
    return f"{FAILS}: no finite elements here take longer than the theory"


@reads()
def saved_follows(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Does the percentage follow from the two printed times?"""
    cost = facts.printed.cost
    own, fea = cost["theoretical model"], cost["finite-element model"]
    value = 100 * (1 - own / fea)
    slack = 100 * rules.rounding * (1 / fea + own / fea**2)
    measured, uncertainty = f"{value:.3f} %", f"{slack:.3f} % (rounding of both times)"
    off = abs(value - cost["cost saved"])
    if off <= rules.rounding + EDGE:
        return Finding(measured, uncertainty, HOLDS)
    if off <= rules.rounding + slack:
        verdict = f"{ONLY_IF} the times had more digits: as printed they give {value:.2f} %"
        return Finding(measured, uncertainty, verdict)
    return Finding(measured, uncertainty, f"{FAILS}: the two times give {value:.2f} %")


@reads("fea_times")
def saved(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Against which finite elements is as much saved? The printed ones are not known."""
    times = facts.fea_times
    needed = 1 / (1 - facts.printed.cost["cost saved"] / 100)
    words, bounds, rough = [], [], []
    for label, values in times.fea.items():
        rounds = min(len(times.own), len(values))
        low, middle, high = _quartiles(100 * (1 - times.own[:rounds] / values[:rounds]))
        words.append(f"{middle:.4g} % against {label}")
        bounds.append(_between(low, high, " %", rounds) if rounds > 1 else "timed once")
        # One digit: the next is the machine's.
        rough.append(f"{label} takes about {float(f'{_ratios(times)[label]:.1g}'):g} times")
    verdict = (
        f"{ONLY_IF} the finite elements take {needed:.2g} times as long as the theory: "
        f"{', '.join(rough)}"
    )
    return Finding("; ".join(words), "; ".join(bounds), _unless_slower(times, verdict))


@reads("times")
def faster(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Is the model clearly faster than both ways with multipliers?"""
    times = facts.times
    rivals = {
        "keeps its multipliers as unknowns": times.saddle_point,
        "solves its constraints by their null space": times.null_space,
    }
    words, bounds, other = [], [], []
    for name, values in rivals.items():
        low, middle, high = _quartiles(times.own / values)
        words.append(f"{middle:.2f} times that of the rival that {name}")
        bounds.append(_between(low, high, "", len(values)))
        if middle > rules.clearly_faster:
            other.append(name)
    measured, uncertainty = "; ".join(words), "; ".join(bounds)
    if not other:
        return Finding(measured, uncertainty, HOLDS)
    if len(other) == len(rivals):
        verdict = f"{FAILS}: it is not clearly faster than either way with multipliers"
        return Finding(measured, uncertainty, verdict)
    (slow,) = (name for name in rivals if name not in other)
    verdict = (
        f"{ONLY_IF} the rival {slow}: against one that {other[0]} it is not clearly faster "
        f"({rules.clearly_faster:g} times or less)"
    )
    return Finding(measured, uncertainty, verdict)
