"""What the verdicts on the paper's claims rest on, each figure measured when it is first asked for.

SI units unless a name says otherwise.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import SimpleNamespace
from typing import Any

import numpy as np
import scipy.linalg

from analytic import Limits, Pose, limbs_at, stiffness
from harness.bench import Bench, Study, label
from harness.case import Case
from harness.cases import PRESETS
from harness.causes import THEORIES as NAMES
from harness.compare import match
from harness.paper import TABLE_ONE, Paper
from harness.presets import LIMB_SOLIDS, PAPER_MODEL, STAND_IN, solid_truth
from harness.signatures import Array
from harness.studies.claims.equations import equations
from harness.studies.cost.work import FORMULATIONS, counted
from harness.studies.precision import SOLVERS, timed_rows
from harness.studies.slenderness import slenderness, with_rods
from harness.studies.workspace import whole
from harness.studies.workspace.checks import largest_ripple, rises, turned
from harness.studies.workspace.map import Region, solve
from harness.timing import Timed, Way, time_ways
from reference_models import Named, UnavailableError, parse

Args = Mapping[str, Any]
Outcome = tuple[str, dict[str, Any]]
"""Which verdict of findings.toml is true, and what its words are filled in with."""
HOLDS = "holds"
CASES = ("case1", "case2")
"""The two of Table I."""
TABLE = tuple(PRESETS[name] for name in CASES)
PAPER = PAPER_MODEL
THEORIES = tuple(Named(name, None) for name in NAMES)
EXACT, _, TIMOSHENKO = THEORIES
STEPS = range(1, 9)
"""Numbers of elements that are solved."""
COST_STEPS = (1, 2, 3, 4, 8, 16, 32, 64)
"""Numbers of elements at which formulations are compared."""
MODES = 6
ROUNDS = 11
THINNEST = 0.02
LIMIT_ANGLES = (30.0, 45.0, 60.0)
HEIGHTS = np.linspace(Limits().length_min, Limits().length_max, 801)
"""The printed stroke, o as high as a limb's end, for one that gives both rows of Table I."""


def checked() -> Paper:
    """Return the paper that this bench is about."""
    assert TABLE[0].paper is not None, "it is one of its cases"
    return TABLE[0].paper


RULES: Any = SimpleNamespace(**checked().toml("claims.toml")["rules"])
"""The thresholds of all checks; see claims.toml, [rules]."""


def outcome(holds: Any, otherwise: str = "otherwise", **values: Any) -> Outcome:
    """Return that a statement holds, or which of its verdicts is true `otherwise`."""
    return HOLDS if holds else otherwise, values


class UnmeasuredError(RuntimeError):
    """A simulator that is there failed, with the reason."""


@dataclass(frozen=True)
class Reference:
    """A simulator's f1-f6 and their numerical uncertainty [Hz] by case, paired by shape."""

    label: str
    hertz: Mapping[str, Array]
    uncertainty: Mapping[str, Array]


@dataclass(frozen=True)
class Spent:
    """What a way takes for a pose.

    Attributes: `seconds` by round; `solves`, those of its eigen-solution, by call; `work` counted:
    operations of a formulation, coordinates of finite elements.
    """

    seconds: Array
    solves: Array
    work: float

    @classmethod
    def of(cls, timed: Timed, work: float) -> "Spent":
        """Return what a way took in every round."""
        return cls(timed.each("seconds"), timed.each("solve"), work)

    def over(self, other: "Spent") -> tuple[Array, Array, float]:
        """Return ratios to another: of seconds and of solves, call by call, and of work."""
        last = slice(-min(len(self.seconds), len(other.seconds)), None)
        seconds = self.seconds[last] / other.seconds[last]
        return seconds, self.solves[last] / other.solves[last], self.work / other.work


class Facts:
    """All figures about `cases`; of those that are `given` nothing is measured.

    Rows of all that was solved, for the history, are in `solved`. A figure that a simulator is
    missing for raises `UnavailableError`, one that it failed at `UnmeasuredError`.
    """

    def __init__(self, bench: Bench, cases: Sequence[Case] = TABLE, **given: Any) -> None:
        self.bench, self.cases = bench, cases
        self.solved: list[dict[str, Any]] = []
        vars(self).update(given)

    def but(self, **given: Any) -> "Facts":
        """Return these facts with others in the place of some."""
        return Facts(**(vars(self) | given))

    @cached_property
    def printed(self) -> Any:
        """The paper's own numbers.

        `table` by case and row, `figure3` by case, s and mode, `cost`, and `matrices` by equation:
        "columns", and by "rows" each one's widths, as (a, b) for a s + b.
        """
        paper = checked()
        return SimpleNamespace(
            table={(name, row): paper.row(name, row) for name in CASES for row in TABLE_ONE},
            figure3=paper.errors, cost=paper.cost, matrices=paper.toml("equations.toml"),
        )  # fmt: skip

    def _keep(self, rows: list[dict[str, Any]], failures: Iterable[str]) -> None:
        self.solved += rows
        if reasons := "; ".join(dict.fromkeys(failures)):
            raise UnmeasuredError(reasons)

    def _kept(self, study: Study) -> Study:
        failures = (f"{label(model)}: {why}" for (_, model), why in study.failures.items())
        self._keep(study.rows(), failures)
        return study

    def _run(self, cases: Sequence[Case], models: Sequence[Named], count: int = MODES) -> Study:
        return self._kept(self.bench.run(cases, models, count))

    def solved_for(self, case: Case, model: Named, count: int) -> Array:
        """Return the first frequencies of a model at a case [Hz], (count,)."""
        return self._run([case], [model], count).answers[case, model].frequencies[:count]

    def _paired(self, study: Study, case: Case, model: Named) -> tuple[Array, Array]:
        """Return f1-f6 and their uncertainty [Hz] in the order of the paper's modes."""
        found = match(study, case, PAPER, model)
        assert found is not None, "both have an answer"
        if found.pairing.doubtful.any():
            lost = 1 + np.argmax(found.pairing.doubtful)
            raise UnmeasuredError(f"{model.label}: no mode at {case.name} looks like f{lost}")
        return found.against, np.nan_to_num(found.uncertainty)

    def reference(self, model: Named) -> Reference:
        """Return a simulator's frequencies, paired by shape."""
        study = self._run(self.cases, [PAPER, model])
        found = {case.name: self._paired(study, case, model) for case in self.cases}
        hertz, uncertainty = ({name: pair[k] for name, pair in found.items()} for k in (0, 1))
        return Reference(model.label, hertz, uncertainty)

    @cached_property
    def fea(self) -> Reference:
        """What stands in for ANSYS."""
        return self.reference(parse(STAND_IN, "reference"))

    @cached_property
    def solid(self) -> Reference:
        """The quickest solid that can run here, extrapolated."""
        solid = solid_truth(LIMB_SOLIDS)
        if solid is None:
            reasons = (f"{name}: {Named(name, None).info().missing}" for name in LIMB_SOLIDS)
            raise UnavailableError("; ".join(reasons))
        return self.reference(solid)

    @cached_property
    def hertz(self) -> dict[tuple[str, Named], Array]:
        """The beam theories' f1-f6 [Hz] by (case, model), in the order of the paper's modes.

        With and without elements at the cases, and every other reading of the paper.
        """
        models = [*(Named(PAPER.name, s) for s in STEPS), *THEORIES]
        study = self._run(self.cases, [PAPER, *models])
        hertz = {(c.name, m): self._paired(study, c, m)[0] for c in self.cases for m in models}
        for case in PRESETS.values():
            hertz.setdefault((case.name, case.theory), self.solved_for(case, case.theory, MODES))
        return hertz

    @cached_property
    def scan(self) -> dict[str, Array]:
        """The paper's model over `HEIGHTS` at each case's angles, (n, 6) [Hz]."""
        scan = {}
        for case in self.cases:
            poses = Pose(HEIGHTS, case.pose.azimuth, case.pose.tilt)
            answers = solve(PAPER, case.mechanism, poses, MODES, self.bench)
            self._keep(answers.rows(), answers.failures.values())
            scan[case.name] = answers.frequencies
        return scan

    @cached_property
    def lengths(self) -> dict[str, Array]:
        """The limbs' lengths of every case and reading."""
        known = [*PRESETS.values(), *self.cases]
        return {case.name: limbs_at(case.mechanism, case.pose).lengths for case in known}

    @cached_property
    def slender(self) -> Any:
        """Both theories as rods grow stout: `ratios` d/L (n,), the last the printed one.

        `frequencies`: largest relative difference of f1-f6 over the cases, (n, 6) [%]; `stiffness`:
        that of the platform's static stiffness, (n,) [%].
        """
        most = max(
            case.mechanism.limbs[0].rod.diameter
            / limbs_at(case.mechanism, case.pose).lengths.mean()
            for case in self.cases
        )
        ratios = np.geomspace(THINNEST, most, 6)
        shown = range(1, MODES + 1)
        result = slenderness(self.cases, ratios.tolist(), [EXACT], TIMOSHENKO, shown, self.bench)
        self._kept(result.study)
        static = [[_stiffness_ratios(with_rods(c, r)) for c in self.cases] for r in ratios.tolist()]
        return SimpleNamespace(
            ratios=ratios,
            frequencies=np.abs([result.errors[case, EXACT] for case in self.cases]).max(axis=0),
            stiffness=100 * np.abs(np.array(static) - 1).max(axis=(1, 2)),
        )

    @cached_property
    def equations(self) -> Any:
        """The residuals of Eqs. (1)-(22) as printed: `equations`."""
        return equations(self.cases)

    def _timed(self, models: Sequence[Named]) -> list[Timed]:
        """Return what every model takes for the last case, all of them in turns."""
        case = self.cases[-1]
        timings = time_ways(self.bench, [Way(m) for m in models], [case], ROUNDS, MODES)
        rows = [row for one in timings.timed for row in timed_rows(one, [case], "claims")]
        missing = timings.left_out if len(timings.timed) < len(models) else {}
        self._keep(rows, (f"{k}: {why}" for k, why in (missing | timings.failures).items()))
        return list(timings.timed)

    @cached_property
    def times(self) -> dict[str, dict[int, Spent]]:
        """What a pose takes without and with multipliers by formulation and s, also counted."""
        kinds = {"paper": PAPER} | {
            solver: Named("multipliers", None, (("solver", solver),)) for solver in SOLVERS
        }
        ways = [(name, s) for s in COST_STEPS for name in FORMULATIONS]
        timed = self._timed([replace(kinds[name], elements=s) for name, s in ways])
        found: dict[str, dict[int, Spent]] = {name: {} for name in FORMULATIONS}
        for (name, s), one in zip(ways, timed, strict=True):
            found[name][s] = Spent.of(one, counted(name, s, self.cases[-1]).flops)
        return found

    @cached_property
    def fea_times(self) -> dict[str, Spent]:
        """What a pose takes by the paper's model, the stand-in for ANSYS, and a solid.

        The solid takes so much longer that it is timed once. `Spent.work` are coordinates: those
        of the paper's way are what it solves for.
        """
        models = [PAPER, parse(STAND_IN, "reference")]
        timed = zip(models, self._timed(models), strict=True)
        found = {model.label: Spent.of(one, one.dofs or 0) for model, one in timed}
        solid, case = solid_truth(), self.cases[-1]
        if solid is not None:
            study = self.bench.run([case], [solid], MODES)
            self.solved += study.rows()
            if modes := study.get(case, solid):
                whole, solve = np.array([modes.seconds]), np.array([modes.solve_seconds])
                found[solid.label] = Spent(whole, solve, modes.dofs)
        return found

    @cached_property
    def maps(self) -> Any:
        """The regular workspace and f1-f3 of the paper's model in it."""
        mechanism, limits, volumes = self.cases[0].mechanism, Limits(), {}
        limbs = len(mechanism.limbs)
        data = whole(Region.of(mechanism, limits), PAPER, 3, self.bench)
        self._keep(data.answers.rows(), data.answers.failures.values())
        change, _ = rises(data)
        for angle in LIMIT_ANGLES:
            most = np.radians(angle).item()
            held = Region.of(mechanism, Limits(spherical_max=most, revolute_max=most))
            volumes[angle] = held.cone.volume, held.circles.volume
        return SimpleNamespace(
            ripple=largest_ripple(data),  # (3,): largest (max - min) / mean round a circle
            turned=turned(data, limbs),  # largest relative change under a turn from limb to limb
            period=360 / limbs,  # that turn [deg]
            steps=np.isfinite(change).sum(),  # from layer to layer
            rising=(change >= 0).sum(),  # those that do not fall
            z=data.grid.z,  # (n,) [m]
            level=data.frequencies[:, 0, 0, 0],  # f1 of the level platform, (n,) [Hz]
            limit=np.degrees(limits.spherical_max),  # of the joints [deg]
            volumes=volumes,  # by limit: of cone, of all circles [rad^2 m]
        )


def _stiffness_ratios(case: Case) -> Array:
    """Return the platform's static stiffness by Euler-Bernoulli over that by Timoshenko, (6,).

    Eigenvalues of the pair: the extremes over all directions of load.
    """
    euler, timoshenko = (
        stiffness(case.mechanism, case.pose, beam=model.name).matrix
        for model in (EXACT, TIMOSHENKO)
    )
    return np.asarray(scipy.linalg.eigh(euler, timoshenko, eigvals_only=True))
