"""Every claim's verdict as the models have it, the rules it follows, and the accepted results."""

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from analytic import Material, Mechanism, Platform, Rod
from harness.bench import Bench
from harness.cases import PRESETS
from harness.paper import Claim
from harness.studies.claims import CANNOT, FAILS, ONLY_IF, Finding, find, judge
from harness.studies.claims.facts import (
    CASES,
    COST_STEPS,
    HOLDS,
    PAPER,
    RULES,
    Facts,
    Reference,
    Spent,
    checked,
)

ASKED = checked().claims
BY_ID = {claim.id: claim for claim in ASKED}
Kind = Callable[[Facts, Claim], str]


@pytest.mark.parametrize("claim", ASKED, ids=lambda claim: claim.id)
def test_verdict(claim: Claim, facts: Facts, kind: Kind, expected: dict[str, str]) -> None:
    assert kind(facts, claim) == expected[claim.id]


def finding(facts: Facts, name: str) -> Finding:
    return find(BY_ID[name], facts)


def test_a_number_agrees_within_its_rounding_and_the_references_uncertainty(facts: Facts) -> None:
    assert facts.printed.table["case1", "FEA"][0] == 114.87
    rounding = RULES.rounding
    for off, own, expected in (
        (0.99 * rounding, 0.0, HOLDS),
        (1.01 * rounding, 0.0, CANNOT),
        (0.99 * (rounding + 0.4), 0.4, HOLDS),
        (1.01 * (rounding + 0.4), 0.4, CANNOT),
    ):
        hertz, uncertainty = {"case1": np.full(6, 114.87 + off)}, {"case1": np.full(6, own)}
        found = Reference("planted", hertz, uncertainty)
        planted = facts.but(fea=found, solid=found)
        assert finding(planted, "table1-case1-fea-f1").kind == expected


def test_references_that_disagree_make_it_a_condition(facts: Facts) -> None:
    planted = Reference("planted", {"case1": np.full(6, 114.87)}, {"case1": np.zeros(6)})
    found = finding(facts.but(fea=planted), "table1-case1-fea-f1")
    assert found.verdict == "holds only if the finite elements are those of planted"


def test_a_mechanism_of_other_stiffness_turns_the_verdict(facts: Facts, bench: Bench) -> None:
    """Frequencies grow with the root of E: so soft a mechanism has the printed f1, and no f3."""
    softer = float((115.02 / facts.hertz["case1", PAPER][0]) ** 2)
    steel = Material(200e9 * softer, 77e9 * softer, 7820)
    robot = Mechanism.regular(0.3, 0.2, Rod(steel, 0.1), Platform.disc(0.2, 0.02, 7820))
    soft = Facts(bench, [replace(PRESETS[name], mechanism=robot) for name in CASES])
    found = {i: finding(soft, f"table1-case1-theoretical-f{i}").kind for i in (1, 2, 3)}
    assert found == {1: HOLDS, 2: HOLDS, 3: CANNOT}


def test_causes_add_up_to_the_error(facts: Facts) -> None:
    found = finding(facts, "error-case1-f4-s3")
    totals = [float(x) for x in re.findall(r"([+-][0-9.]+) % against", found.measured)]
    parts = [float(x) for x in re.findall(r"[+-][0-9.]+(?=[,;]|$)", found.verdict)]
    assert len(parts) == 8
    np.testing.assert_allclose([sum(parts[:4]), sum(parts[4:])], totals, atol=2e-3)
    assert "mostly shear" in found.verdict
    coarse = {("case1", PAPER): facts.hertz["case1", replace(PAPER, elements=1)]}
    found = finding(facts.but(hertz=facts.hertz | coarse), "error-case1-f4-s3")
    assert "mostly number of elements" in found.verdict


def formulations(
    facts: Facts, work: dict[str, float], solves: dict[str, float] | None = None, at: int = 0
) -> Facts:
    """Rivals with so many times the paper's operations and solve time, at s = `at` or at all."""
    changed = {name: dict(own) for name, own in facts.times.items()}
    for name, factor in work.items():
        for s in [at] if at else COST_STEPS:
            own = facts.times["paper"][s]
            time = own.solves * (solves or {}).get(name, 1.5)
            changed[name][s] = Spent(own.seconds, time, factor * own.work)
    return facts.but(times=changed)


BOTH = ("null-space", "saddle-point")


def test_counted_operations_turn_the_verdict_on_multipliers(facts: Facts) -> None:
    """Sign decides, at every number of elements: one per cent is enough, equality is not."""
    verdicts = {
        factor: finding(
            formulations(facts, dict.fromkeys(BOTH, factor), dict.fromkeys(BOTH, solves)),
            "faster-without-multipliers",
        ).kind
        for factor, solves in ((1.01, 1.5), (1.0, 1.5), (0.99, 0.9))
    }
    assert verdicts == {1.01: HOLDS, 1.0: ONLY_IF, 0.99: FAILS}
    one = formulations(facts, {"null-space": 0.9}, at=64)
    assert finding(one, "faster-without-multipliers").verdict == (
        "holds only if the rival that solves its constraints by their null space has "
        "s = 1, 2, 3, 4, 8, 16, 32"
    )


def test_the_time_of_eigen_solutions_turns_the_verdict_on_multipliers(facts: Facts) -> None:
    """Where it says the opposite of the operations; within its scatter it says nothing."""
    more = dict.fromkeys(BOTH, 1.2)
    for solves, kind in ((1.5, HOLDS), (1.0, HOLDS), (0.5, ONLY_IF)):
        here = formulations(facts, more, {"null-space": solves}, at=2)
        assert finding(here, "faster-without-multipliers").kind == kind


def test_no_interpreter_moves_the_verdict_on_multipliers(facts: Facts) -> None:
    """All seconds but those of the eigen-solutions may be anything."""
    for factor in (0.1, 10.0):
        slow = {
            s: replace(one, seconds=factor * one.seconds) for s, one in facts.times["paper"].items()
        }
        here = facts.but(times={**facts.times, "paper": slow})
        assert finding(here, "faster-without-multipliers") == finding(
            facts, "faster-without-multipliers"
        )


def test_no_chance_agreement_of_seconds_is_a_verdict(facts: Facts) -> None:
    """Not even the printed times themselves, of a machine and finite elements that nobody knows."""
    own = Spent(np.full(3, 0.82), np.full(3, 0.5), 54)
    for fea, times in ((6.16, "8"), (5.0, "6"), (82.0, "100")):
        planted = {PAPER.label: own, "planted": Spent(np.full(3, fea), np.full(3, 1.0), 444)}
        here = facts.but(fea_times=planted)
        assert finding(here, "time-theoretical").kind == finding(here, "time-fea").kind == CANNOT
        assert finding(here, "time-saved").verdict == (
            "holds only if the finite elements take 7.5 times as long as the theory: planted takes "
            f"about {times} times"
        )


@pytest.mark.parametrize("rival", [(0.8, 0.9, 444), (0.9, 0.8, 444), (0.9, 0.9, 54)])
def test_finite_elements_that_take_less_turn_the_verdicts_on_times(
    facts: Facts, rival: tuple[float, float, int]
) -> None:
    """In seconds, in those of the eigen-solution, or in coordinates: one is enough."""
    whole, solve, coordinates = rival
    planted = {
        PAPER.label: Spent(np.full(3, 0.82), np.full(3, 0.82), 54),
        "planted": Spent(np.full(3, whole), np.full(3, solve), coordinates),
    }
    for name in ("time-theoretical", "time-fea", "time-saved"):
        assert finding(facts.but(fea_times=planted), name).verdict == (
            "fails: no finite elements here take more than the theory in seconds, in those of the "
            "eigen-solution and in coordinates at once"
        )


@pytest.mark.slow
def test_real_simulators_give_the_same_verdicts(
    facts: Facts, expected: dict[str, str], bench: Bench
) -> None:
    """Only timings are left out: a busy machine may change them."""
    real = Facts(bench)
    chosen = [c for c in ASKED if c.check in ("fea", "error", "largest_error")]
    result = judge(chosen, real)
    assert result.found and not result.failures()
    assert {c.claim.id: c.kind for c in result.found} == {c.id: expected[c.id] for c in chosen}
    # The frequencies that the quick tests stand on are what comes out.
    for one, stored in ((real.fea, facts.fea), (real.solid, facts.solid)):
        assert one and stored and one.label == stored.label
        for case in CASES:
            np.testing.assert_allclose(one.hertz[case], stored.hertz[case], rtol=1e-6)
            assert (one.uncertainty[case] > 0).all()
