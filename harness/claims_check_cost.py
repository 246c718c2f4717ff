"""Checks of what the model costs: medians of rounds in turns, with their quartiles."""

import numpy as np

from harness.claims_check_printed import EDGE
from harness.claims_data import CANNOT, FAILS, HOLDS, ONLY_IF, Claim, Finding, Rules
from harness.claims_facts import PAPER, Facts, Floats


def _quartiles(values: Floats) -> tuple[float, float, float]:
    low, middle, high = (float(v) for v in np.percentile(values, [25, 50, 75]))
    return low, middle, high


def _between(low: float, high: float, unit: str, rounds: int) -> str:
    return f"{low:.4g} to {high:.4g}{unit} (quartiles of {rounds} rounds)"


def seconds(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Does a pose take the printed time?"""
    times, quantity = facts.fea_times, claim.args["quantity"]
    assert times
    label, values = {
        "theoretical model": (PAPER, times.own),
        "finite-element model": (times.label, times.fea),
    }[quantity]
    quoted = facts.printed.cost[quantity]
    low, middle, high = _quartiles(values)
    measured = f"{middle:.4g} s by {label}"
    uncertainty = _between(low, high, " s", len(values))
    if low - rules.rounding <= quoted <= high + rules.rounding:
        return Finding(measured, uncertainty, HOLDS)
    verdict = (
        f"{CANNOT}: no machine, program or problem size is printed; here it takes "
        f"{100 * middle / quoted:.2g} % of that"
    )
    return Finding(measured, uncertainty, verdict)


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


def saved(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Is as much saved here?"""
    times = facts.fea_times
    assert times
    rounds = min(len(times.own), len(times.fea))
    low, middle, high = _quartiles(100 * (1 - times.own[:rounds] / times.fea[:rounds]))
    measured = f"{middle:.2f} % against {times.label}"
    uncertainty = _between(low, high, " %", rounds)
    quoted = facts.printed.cost["cost saved"]
    if low - rules.rounding <= quoted <= high + rules.rounding:
        return Finding(measured, uncertainty, HOLDS)
    verdict = f"{CANNOT}: it depends on the finite elements set against it, which are not printed"
    return Finding(measured, uncertainty, verdict)


def faster(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Is the model faster than both ways with multipliers?"""
    times = facts.times
    assert times
    rivals = {
        "multipliers kept as unknowns": times.saddle_point,
        "constraints solved by their null space": times.null_space,
    }
    words, bounds, slower = [], [], []
    for name, values in rivals.items():
        low, middle, high = _quartiles(times.own / values)
        words.append(f"{middle:.2f} times that with {name}")
        bounds.append(_between(low, high, "", len(values)))
        if high >= 1:
            slower.append(name)
    measured, uncertainty = "; ".join(words), "; ".join(bounds)
    if not slower:
        return Finding(measured, uncertainty, HOLDS)
    if len(slower) == len(rivals):
        return Finding(measured, uncertainty, f"{FAILS}: neither way with multipliers is slower")
    (quicker,) = (name for name in rivals if name not in slower)
    verdict = f"{ONLY_IF} the rival is that with {quicker}, not {slower[0]}"
    return Finding(measured, uncertainty, verdict)
