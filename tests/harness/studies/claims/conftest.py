"""The facts that claims are judged by: the models' own, the simulators' as accepted, no timing."""

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from harness.cases import PRESETS
from harness.studies.claims.checks import CHECKS
from harness.studies.claims.claims import judge
from harness.studies.claims.data import CANNOT, FAILS, HOLDS, ONLY_IF, Claim
from harness.studies.claims.equations import equations
from harness.studies.claims.facts import CASES, Facts, FeaTimes, Reference, Times
from harness.studies.claims.measure import beams, maps, printed, slender

RESULTS = Path(__file__).parents[3] / "results"
TABLE = [PRESETS[name] for name in CASES]

ROWS = {
    kind: [name.format(case=case, i=i) for name in names for case in CASES for i in range(1, 7)]
    for kind, names in {
        CANNOT: (
            "table1-{case}-theoretical-f{i}", "table1-{case}-fea-f{i}", "error-{case}-f{i}-s3",
        ),
        HOLDS: ("table1-{case}-error-f{i}",),
    }.items()
}  # fmt: skip
SINGLE = {
    HOLDS: """three-degrees-of-freedom eq1-rotation eq2-plane eq3-lengths slender-members eq6-size
        eq10-compatibility eq12-blocks eq17-vertical eq19-dimension no-multipliers
        multipliers-unknowns f1-case2-one-to-three f1-elements three-elements
        largest-printed-f1-f3 largest-printed-f1 largest-printed-f4 less-than-f1-f3
        case1-repeated time-saved-follows falls-with-height work-low""",
    ONLY_IF: """timoshenko-stiffness timoshenko-frequencies eq14-base-angles eq17-regular
        eq18-singular eq21-blocks faster-without-multipliers table1-case1-error-f2 less-than-f1
        f1-error-and-diameter time-saved height-within-limits truncated-cone
        circular-symmetry""",
    CANNOT: """error-case1-f1-s1 error-case2-f1-s1 model-verified-f1-f3 model-verified-f1
        time-theoretical time-fea eq25-limits""",
    FAILS: """name-3-prs eq1-angles eq8-inertia table1-case2-error-f5 table1-case2-error-f6
        f1-case1-one-to-three largest-printed-f5 largest-printed-f6 cases-share-height""",
}
EXPECTED = {name: kind for kind, names in ROWS.items() for name in names}
EXPECTED |= {name: kind for kind, names in SINGLE.items() for name in names.split()}


@pytest.fixture(scope="session")
def expected() -> dict[str, str]:
    """Every claim's id to the kind of its verdict."""
    return EXPECTED


@pytest.fixture(scope="session")
def facts() -> Facts:
    """All but the maps. Timings are made up: a test must not depend on how busy a machine is."""
    noise = np.array([0.99, 1.0, 1.01])
    return Facts(
        printed(),
        beams=beams(TABLE, []),
        fea=_accepted("exudyn-beam@12+24", 2e-3),
        solid=_accepted("ngsolve-solid@2+4", 4e-4),
        slender=slender(TABLE, []),
        equations=equations(TABLE),
        times=Times(0.005 * noise, 0.0045 * noise, 0.01 * noise),
        fea_times=FeaTimes(
            0.005 * noise,
            {"exudyn-beam@12+24": 0.03 * noise, "calculix-solid@8+12": np.array([14.5])},
        ),
    )


def _accepted(label: str, uncertainty: float) -> Reference:
    """A simulator's accepted frequencies, with a relative uncertainty like its own."""
    with (RESULTS / "frequencies.csv").open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["model"] == label]
    hertz = {
        case: np.array([float(row["frequency_hz"]) for row in rows if row["case"] == case])[:6]
        for case in CASES
    }
    return Reference(label, hertz, {case: uncertainty * f for case, f in hertz.items()})


@pytest.fixture(scope="session")
def mapped_facts(facts: Facts) -> Facts:
    """With the maps, which take seconds."""
    return replace(facts, maps=maps(PRESETS["case1"], []))


@pytest.fixture
def facts_for(request: pytest.FixtureRequest) -> Callable[[Claim], Facts]:
    """The facts that a claim's check reads."""

    def choose(claim: Claim) -> Facts:
        mapped = "maps" in CHECKS[claim.check].groups
        return request.getfixturevalue("mapped_facts" if mapped else "facts")  # type: ignore[no-any-return]

    return choose


@pytest.fixture(scope="session")
def kind() -> Callable[[Facts, Claim], str]:
    """The kind of the verdict on a claim."""

    def judged(facts: Facts, claim: Claim) -> str:
        (checked,), unchecked = judge([claim], facts, {})
        assert not unchecked
        return checked.finding.kind

    return judged
