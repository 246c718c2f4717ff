"""Every claim's verdict turns when a model, or what is printed, is another."""

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analytic import Mechanism, Platform
from analytic.substructure import rigid_arm
from harness.cases import PRESETS
from harness.paper import FORMS, Claim
from harness.studies.claims import CHECKS, FAILS, KINDS, WORDS, find
from harness.studies.claims import equations as claims_equations
from harness.studies.claims.check_cost import faster
from harness.studies.claims.equations import equations, printed_position, printed_rotation
from harness.studies.claims.facts import CASES, PAPER, TABLE, Facts, Reference, Spent, checked

SLOW_THEORY = {
    label: Spent(np.full(3, seconds), np.full(3, seconds), coordinates)
    for label, seconds, coordinates in (
        (PAPER.label, 7.0, 54), ("planted", 6.16, 444), ("other", 1.0, 444),
    )
}  # fmt: skip


def changed(group: Any, **change: Any) -> SimpleNamespace:
    return SimpleNamespace(**(vars(group) | change))


def own_row(facts: Facts, claim: Claim) -> Facts:
    """Print our values: what could not be reproduced then holds."""
    case, method = claim.args["case"], claim.args["method"]
    ours = {"Theoretical": facts.hertz[case, PAPER], "FEA": facts.fea.hertz[case]}[method]
    rounded = tuple(float(f) for f in np.round(ours, 2))
    facts = print_row(facts, case, method, rounded)
    # Both kinds of finite elements the same: the stand-in's.
    return facts.but(solid=facts.fea)


def print_row(facts: Facts, case: str, method: str, row: tuple[float, ...]) -> Facts:
    table = dict(facts.printed.table) | {(case, method): row}
    return facts.but(printed=changed(facts.printed, table=table))


def other_error(facts: Facts, claim: Claim) -> Facts:
    """Print the error that the rows give, or another if it already is."""
    case, i = claim.args["case"], claim.args["mode"] - 1
    theory, fea, row = (facts.printed.table[case, m] for m in ("Theoretical", "FEA", "Error (%)"))
    value = round(100 * (theory[i] - fea[i]) / fea[i], 2)
    if abs(value - row[i]) < 0.001:
        value += 0.1
    return print_row(facts, case, "Error (%)", (*row[:i], value, *row[i + 1 :]))


def other_rows(facts: Facts, claim: Claim) -> Facts:
    """Print theoretical values that have the printed errors, or, where these hold, 1 % more."""
    more = 1.01 if find(claim, facts).kind != FAILS else 1.0
    for case in CASES:
        fea, error = (np.array(facts.printed.table[case, m]) for m in ("FEA", "Error (%)"))
        row = tuple(float(f) for f in more * fea * (1 + error / 100))
        facts = print_row(facts, case, "Theoretical", row)
    return facts


def agreeing_references(facts: Facts, claim: Claim) -> Facts:
    """Finite elements of which the printed error would be true."""
    i, s = claim.args["mode"] - 1, claim.args["elements"]
    case = claim.args["case"]
    quoted = facts.printed.table[case, "Error (%)"][i]
    if "method" not in claim.args:
        quoted = facts.printed.figure3[case, s, i + 1]
    hertz = {c: facts.hertz[c, replace(PAPER, elements=s)] / (1 + quoted / 100) for c in CASES}
    none = {c: np.zeros(6) for c in CASES}
    return facts.but(fea=Reference("a", hertz, none), solid=Reference("b", hertz, none))


def perfect_references(facts: Facts, claim: Claim) -> Facts:
    """Finite elements of the theory's own beams."""
    return agreeing_references(
        facts, replace(claim, args={"case": "case1", "mode": 1, "elements": 3, "method": ""})
    )


def with_elements(coarse: int, as_if: int) -> Callable[[Facts, Claim], Facts]:
    """The model with `coarse` elements in place of `as_if`."""

    def flip(facts: Facts, claim: Claim) -> Facts:
        hertz = dict(facts.hertz)
        for case in CASES:
            model = replace(PAPER, elements=as_if)
            hertz[case, model] = hertz[case, replace(PAPER, elements=coarse)]
        return facts.but(hertz=hertz)

    return flip


def stiffer_single_element(facts: Facts, claim: Claim) -> Facts:
    """One element that is wrong by as much as the significance allows, twice over."""
    hertz = dict(facts.hertz)
    one = ("case1", replace(PAPER, elements=1))
    hertz[one] = 1.02 * hertz[one]
    return facts.but(hertz=hertz)


def other_fall(facts: Facts, claim: Claim) -> Facts:
    """Case 1: print our own fall of f1. Case 2: two elements in place of one."""
    case = claim.args["case"]
    if case == "case2":
        return with_elements(2, 1)(facts, claim)
    one, three = (facts.hertz[case, replace(PAPER, elements=s)][0] for s in (1, 3))
    fall = 100 * (one / three - 1)
    figure3 = dict(facts.printed.figure3)
    figure3[case, 1, 1] = facts.printed.table[case, "Error (%)"][0] + fall
    return facts.but(printed=changed(facts.printed, figure3=figure3))


def tilted(facts: Facts, claim: Claim) -> Facts:
    """Case 2's frequencies in place of the symmetric pose's."""
    hertz = dict(facts.hertz) | {("case1", PAPER): facts.hertz["case2", PAPER]}
    return facts.but(hertz=hertz)


def lengths(**spans: tuple[float, float]) -> Callable[[Facts, Claim], Facts]:
    def flip(facts: Facts, claim: Claim) -> Facts:
        named = {name.replace("_", "-"): span for name, span in spans.items()}
        found = dict(facts.lengths) | named
        return facts.but(lengths=found)

    return flip


def one_height_for_both(facts: Facts, claim: Claim) -> Facts:
    """Print both rows of our model at one and the same height."""
    for case in CASES:
        row = tuple(float(f) for f in facts.scan[case][300])
        facts = print_row(facts, case, "Theoretical", row)
    return facts


def thin_rods(facts: Facts, claim: Claim) -> Facts:
    """The same mechanism with rods a tenth as thick."""
    found = facts.slender
    assert found and found.ratios[0] < 0.11 * found.ratios[-1]
    thin = {name: getattr(found, name)[:1] for name in ("ratios", "frequencies", "stiffness")}
    return facts.but(slender=changed(found, **thin))


def never_the_same(facts: Facts, claim: Claim) -> Facts:
    """A Timoshenko beam whose shear does not vanish with its diameter."""
    more = facts.slender.frequencies + 0.2
    return facts.but(slender=changed(facts.slender, frequencies=more))


def wrong(which: str) -> Callable[[Facts, Claim], Facts]:
    """The equations with a slip in one of them."""
    formulas: dict[str, Any] = {
        "rotation": {"rotation": lambda phi, theta: printed_rotation(phi, theta) + 0.01},
        "angles": {"rotation": _about_x_and_y},
        "position": {"position": lambda *a: tuple(2 * v for v in printed_position(*a))},
        "arm": {"arm": lambda a: rigid_arm(-a)},
        "platform": {"platform": Platform.disc},
    }[which]
    return lambda facts, claim: facts.but(equations=equations(TABLE, **formulas))


def _about_x_and_y(phi: Any, theta: Any) -> Any:
    """Return theta about x, then phi about y: what Section 2 says in words."""
    c, s, ct, st = np.cos(phi), np.sin(phi), np.cos(theta), np.sin(theta)
    zero = 0 * c
    rows = [[c, s * st, s * ct], [zero, ct, -st], [-s, c * st, c * ct]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def equation_facts(change: Callable[[Any], dict[str, Any]]) -> Callable[[Facts, Claim], Facts]:
    """Other residuals, of a model that `change` describes."""

    def flip(facts: Facts, claim: Claim) -> Facts:
        return facts.but(equations=changed(facts.equations, **change(facts.equations)))

    return flip


def _two_limbs(_: Any) -> dict[str, Any]:
    robot = Mechanism.paper()
    case = replace(PRESETS["case1"], mechanism=replace(robot, limbs=robot.limbs[:2]))
    return {"freedoms": claims_equations._freedoms(case)}


def _sizes(change: Callable[[int, int, int, int], tuple[int, int, int, int]]) -> Any:
    return equation_facts(lambda e: {"sizes": {s: change(*row) for s, row in e.sizes.items()}})


def other_blocks(facts: Facts, claim: Claim) -> Facts:
    """Widen a block of the seventh row of Q by one, or of H_1's first."""
    name, row = {"eq12": ("eq12", "H_1 row 1"), "eq21": ("eq21", "row 7")}[claim.args["equation"]]
    matrix = facts.printed.matrices[name]
    (a, b), *others = matrix["rows"][row]
    rows = matrix["rows"] | {row: ((a, b + 1), *others)}
    matrices = {**facts.printed.matrices, name: matrix | {"rows": rows}}
    return facts.but(printed=changed(facts.printed, matrices=matrices))


def other_percentage(facts: Facts, claim: Claim) -> Facts:
    cost = dict(facts.printed.cost) | {"cost saved": 66.9}
    return facts.but(printed=changed(facts.printed, cost=cost))


def timings(**given: Any) -> Callable[[Facts, Claim], Facts]:
    return lambda facts, claim: facts.but(**given)


def cheaper_null_space(facts: Facts, claim: Claim) -> Facts:
    """A null space that takes few operations at one number of elements; all seconds stay."""
    own = dict(facts.times["null-space"])
    own[3] = replace(own[3], work=facts.times["paper"][3].work)
    return facts.but(times={**facts.times, "null-space": own})


def map_facts(change: Callable[[Any], dict[str, Any]]) -> Callable[[Facts, Claim], Facts]:
    def flip(facts: Facts, claim: Claim) -> Facts:
        return facts.but(maps=changed(facts.maps, **change(facts.maps)))

    return flip


FLIPS: dict[str, Callable[[Facts, Claim], Facts]] = {
    "three_prs": lengths(case1=(0.5, 0.5), case2=(0.5, 0.5)),
    "mobility": equation_facts(_two_limbs),
    "rotation": wrong("rotation"),
    "angles": wrong("angles"),
    "plane": wrong("position"),
    "lengths": wrong("position"),
    "timoshenko_stiffness": thin_rods,
    "timoshenko_frequencies": thin_rods,
    "slender": never_the_same,
    "f1_diameter": thin_rods,
    "rod_size": _sizes(lambda rod, all_, rank, K: (rod - 1, all_, rank, K)),
    "inertia": wrong("platform"),
    "compatibility": wrong("arm"),
    "blocks": other_blocks,
    "base_angles": equation_facts(lambda e: {"base_clamped": dict.fromkeys(CASES, np.zeros(6))}),
    "eq17": equation_facts(lambda e: {"eq17": np.full_like(e.eq17, 0.5)}),
    "eq17_vertical": equation_facts(lambda e: {"axis_rise": 0.1}),
    "eq18": equation_facts(lambda e: {"axis_motion": 0.1}),
    "dimension": _sizes(lambda rod, all_, rank, K: (rod, all_, rank - 1, K)),
    "no_multipliers": equation_facts(lambda e: {"multipliers_apart": 1e-3}),
    "unknowns": _sizes(lambda rod, all_, rank, K: (rod, all_ - 60, rank, K)),
    "faster": cheaper_null_space,
    "theoretical": own_row,
    "fea": own_row,
    "error_follows": other_error,
    "error": agreeing_references,
    "fall": other_fall,
    "few_elements": lambda f, c: (
        with_elements(1, 3) if c.args["elements"] == 3 else stiffer_single_element
    )(f, c),
    "largest_printed": other_rows,
    "largest_error": perfect_references,
    "repeated": tilted,
    "height": lengths(case1_as_printed=(0.4, 0.6), case2_as_printed=(0.4, 0.6)),
    "one_height": one_height_for_both,
    "seconds": timings(fea_times=SLOW_THEORY),
    "saved_follows": other_percentage,
    "saved": timings(fea_times=SLOW_THEORY),
    "angle_limits": map_facts(lambda m: {"volumes": dict.fromkeys(m.volumes, (1.0, 1.0))}),
    "cone": map_facts(lambda m: {"volumes": dict.fromkeys(m.volumes, (1.0, 1.0))}),
    "symmetry": map_facts(lambda m: {"ripple": np.zeros(3)}),
    "falls": map_facts(lambda m: {"rising": 10}),
    "lowest_best": map_facts(lambda m: {"level": m.level[::-1]}),
}


ASKED = checked().claims


@pytest.mark.parametrize("claim", ASKED, ids=lambda claim: claim.id)
def test_a_wrong_model_turns_the_verdict(
    claim: Claim, facts: Facts, kind: Callable[[Facts, Claim], str], expected: dict[str, str]
) -> None:
    turned = kind(FLIPS[claim.check](facts, claim), claim)
    assert turned in KINDS and turned != expected[claim.id]


def more_coordinates(facts: Facts, claim: Claim) -> Facts:
    """The theory with more coordinates than any finite elements; all seconds stay."""
    own, *others = facts.fea_times.items()
    most = 1 + max(spent.work for _, spent in others)
    return facts.but(fea_times=dict([(own[0], replace(own[1], work=most)), *others]))


MORE_WORK = {
    "faster": cheaper_null_space, "seconds": more_coordinates, "saved": more_coordinates,
}  # fmt: skip


@pytest.mark.parametrize(
    "claim", [c for c in ASKED if c.check in MORE_WORK], ids=lambda claim: claim.id
)
def test_counted_work_alone_turns_claims_on_cost(
    claim: Claim, facts: Facts, kind: Callable[[Facts, Claim], str], expected: dict[str, str]
) -> None:
    assert kind(MORE_WORK[claim.check](facts, claim), claim) != expected[claim.id]


def test_claims_on_cost_are_those_whose_work_is_counted() -> None:
    assert {name for name in CHECKS if CHECKS[name].__module__ == faster.__module__} == set(
        MORE_WORK
    )


def test_no_claim_is_left_without_its_flip(expected: dict[str, str]) -> None:
    ids = [claim.id for claim in ASKED]
    assert len(ids) == len(set(ids))
    assert set(expected) == set(ids)
    assert set(FLIPS) == {claim.check for claim in ASKED}
    assert set(CHECKS) == set(FLIPS) | FORMS.keys()


def test_every_check_has_its_words() -> None:
    assert set(WORDS) == set(CHECKS)
    for own in WORDS.values():
        verdicts = own.keys() - {"measured", "uncertainty"}
        assert "otherwise" in verdicts
        assert all(own[name].startswith(KINDS[1:]) for name in verdicts)
