"""The facts that claims are judged by: the models' own, the simulators' as accepted, no timing."""

from collections.abc import Callable, Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from harness.bench import Bench
from harness.cases import PRESETS
from harness.paper import Claim
from harness.studies.claims import CANNOT, FAILS, ONLY_IF, find
from harness.studies.claims.facts import CASES, COST_STEPS, HOLDS, PAPER, Facts, Reference, Spent
from harness.studies.cost.work import counted

SIMULATED = {
    "exudyn-beam@12+24": {
        "case1": (135.824200, 135.824200, 232.203487, 757.925121, 837.163172, 837.163172),
        "case2": (123.007049, 147.184225, 236.520627, 691.168969, 850.012220, 895.299235),
    },
    "ngsolve-solid@2+4": {
        "case1": (136.638490, 136.638490, 233.775288, 759.105085, 838.864461, 838.864461),
        "case2": (123.710029, 148.097804, 238.143135, 692.179292, 851.673911, 897.744625),
    },
}
"""f1-f6 [Hz] as `rps-bench table` gives them."""
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
        multipliers-unknowns faster-without-multipliers f1-case2-one-to-three f1-elements
        three-elements
        largest-printed-f1-f3 largest-printed-f1 largest-printed-f4 less-than-f1-f3
        case1-repeated time-saved-follows falls-with-height work-low""",
    ONLY_IF: """timoshenko-stiffness timoshenko-frequencies eq14-base-angles eq17-regular
        eq18-singular eq21-blocks table1-case1-error-f2 less-than-f1
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
def bench() -> Iterator[Bench]:
    """One bench for all: nothing is solved twice."""
    with Bench() as own:
        yield own


@pytest.fixture(scope="session")
def facts(bench: Bench) -> Facts:
    """Timings are made up: a test must not depend on how busy a machine is."""
    noise = np.array([0.99, 1.0, 1.01])
    return Facts(
        bench,
        fea=_solved_once("exudyn-beam@12+24", 2e-3),
        solid=_solved_once("ngsolve-solid@2+4", 4e-4),
        times=spent(null_space=0.0055 * noise, saddle_point=0.01 * noise),
        fea_times={
            PAPER.label: elements(0.005 * noise, 54),
            "exudyn-beam@12+24": elements(0.03 * noise, 444),
            "calculix-solid@8+12": elements(np.array([14.5]), 17_000),
        },
    )


def spent(**seconds: NDArray[np.float64]) -> dict[str, dict[int, Spent]]:
    """Seconds that are made up, with the operations that are counted."""
    ways = {"paper": np.full(3, 0.005)} | {k.replace("_", "-"): v for k, v in seconds.items()}
    return {
        name: {s: Spent(t, t / 2, counted(name, s, PRESETS["case2"]).flops) for s in COST_STEPS}
        for name, t in ways.items()
    }


def elements(seconds: NDArray[np.float64], coordinates: float) -> Spent:
    """Seconds and coordinates of finite elements, made up."""
    return Spent(seconds, seconds / 2, coordinates)


def _solved_once(label: str, uncertainty: float) -> Reference:
    """A simulator's frequencies as it gave them, with a relative uncertainty like its own."""
    hertz = {case: np.array(f) for case, f in SIMULATED[label].items()}
    return Reference(label, hertz, {case: uncertainty * f for case, f in hertz.items()})


@pytest.fixture(scope="session")
def kind() -> Callable[[Facts, Claim], str]:
    """The kind of the verdict on a claim."""
    return lambda facts, claim: find(claim, facts).kind
