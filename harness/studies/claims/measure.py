"""Measures the figures that the claims' verdicts rest on, with the bench and other studies."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.linalg

from analytic import Limits, Pose, Substructure, limbs_at
from harness.bench import Bench, Study
from harness.cases import PRESETS, Case
from harness.presets import LIMB_SOLIDS, PAPER_ELEMENTS, STAND_IN, solid_truth
from harness.studies.claims.equations import equations
from harness.studies.claims.facts import (
    CASES,
    COST_STEPS,
    EXACT,
    PAPER,
    STEPS,
    THEORIES,
    TIMOSHENKO,
    Beams,
    Facts,
    Floats,
    Maps,
    Reference,
    Slender,
    Spent,
)
from harness.studies.cost.work import FORMULATIONS, counted
from harness.studies.precision import SOLVERS, timed_rows
from harness.studies.slenderness import slenderness, with_rods
from harness.studies.workspace import whole
from harness.studies.workspace.checks import largest_ripple, rises, turned
from harness.studies.workspace.map import Region, solve
from harness.timing import Timed, Way, time_ways
from reference_models import Named, UnavailableError, parse

Row = dict[str, Any]
Cases = Sequence[Case]

MODES = 6
ROUNDS = 11
THINNEST = 0.02
LIMIT_ANGLES = (30.0, 45.0, 60.0)
HEIGHTS = 801
"""Heights of the scan for one that gives both rows of Table I."""


class UnmeasuredError(RuntimeError):
    """A simulator that is there failed, with the reason."""


def gather(groups: Iterable[str], bench: Bench) -> tuple[Facts, dict[str, str], list[Row]]:
    """Return the facts of `groups`, why a group could not be measured, and all that was solved.

    The last as rows for the history.
    """
    cases = [PRESETS[name] for name in CASES]
    solved: list[Row] = []
    found: dict[str, Any] = {}
    missing: dict[str, str] = {}
    for group in sorted(groups, key=list(GROUPS).index):
        try:
            found[group] = GROUPS[group](cases, bench, solved)
        except (UnavailableError, UnmeasuredError) as error:
            missing[group] = str(error)
    return Facts(**found), missing, solved


def _sound(failures: Iterable[str]) -> None:
    """Raise `UnmeasuredError` if anything failed."""
    if reasons := "; ".join(dict.fromkeys(failures)):
        raise UnmeasuredError(reasons)


def _solved(study: Study, solved: list[Row]) -> Study:
    """Return `study`, its rows added to `solved`; raises `UnmeasuredError` if anything failed."""
    solved += study.rows()
    _sound(f"{m.label}: {why}" for (_, m), why in study.failures.items())  # type: ignore[attr-defined]
    return study


def beams(cases: Cases, bench: Bench, solved: list[Row]) -> Beams:
    """Return the theories with and without elements at `cases`, and all readings of the paper.

    As everywhere below, rows of what is solved are added to `solved`.
    """
    models = [*(Named(PAPER.name, s) for s in STEPS), *THEORIES]
    study = _solved(bench.run(cases, [PAPER, *models], MODES), solved)
    hertz = {(case.name, m): _paired(study, case, m)[0] for case in cases for m in models}
    for case in PRESETS.values():
        reading = _solved(bench.run([case], [case.theory], MODES), solved)
        own = reading.answers[case, case.theory].frequencies[:MODES]
        hertz.setdefault((case.name, case.theory), own)
    # The printed stroke, level: o is as high as a limb's end.
    scan_z = np.linspace(Limits().length_min, Limits().length_max, HEIGHTS)
    scan = {}
    for case in cases:
        poses = Pose(scan_z, case.pose.azimuth, case.pose.tilt)
        answers = solve(PAPER, case.mechanism, poses, MODES, bench)
        _sound(answers.failures.values())
        solved += answers.rows(PAPER, case.mechanism, poses)
        scan[case.name] = answers.frequencies
    lengths = {c.name: limbs_at(c.mechanism, c.pose).lengths for c in [*PRESETS.values(), *cases]}
    spans = {name: (float(found.min()), float(found.max())) for name, found in lengths.items()}
    return Beams(hertz, scan_z, scan, spans)


def _paired(study: Study, case: Case, model: Named) -> tuple[Floats, Floats]:
    """Return f1-f6 and their uncertainty [Hz] in the order of the paper's modes."""
    modes, pairing = study.answers[case, model], study.pairing(case, PAPER, model)
    assert pairing is not None, "both have an answer"
    if pairing.doubtful.any():
        lost = 1 + int(np.argmax(pairing.doubtful))
        raise UnmeasuredError(f"{model.label}: no mode at {case.name} looks like f{lost}")
    own = np.zeros(len(modes.frequencies)) if modes.uncertainty is None else modes.uncertainty
    return modes.frequencies[pairing.partner], own[pairing.partner]


def reference(cases: Cases, model: Named, bench: Bench, solved: list[Row]) -> Reference:
    """Return a simulator's frequencies, paired by shape, or raise `UnmeasuredError`."""
    study = _solved(bench.run(cases, [PAPER, model], MODES), solved)
    found = {case.name: _paired(study, case, model) for case in cases}
    hertz, uncertainty = ({name: pair[k] for name, pair in found.items()} for k in (0, 1))
    return Reference(model.label, hertz, uncertainty)


def _solid() -> Named:
    """Return the quickest solid that can run here, extrapolated; else `UnavailableError`."""
    solid = solid_truth(LIMB_SOLIDS)
    if solid is None:
        reasons = (f"{name}: {Named(name, None).info().missing}" for name in LIMB_SOLIDS)
        raise UnavailableError("; ".join(reasons))
    return solid


def slender(cases: Cases, bench: Bench, solved: list[Row]) -> Slender:
    """Return how both theories differ from rods of d/L = `THINNEST` up to the printed ones."""
    rods = [case.mechanism.limbs[0].rod.diameter for case in cases]
    lengths = [limbs_at(case.mechanism, case.pose).lengths.mean() for case in cases]
    ratios = np.geomspace(THINNEST, max(d / L for d, L in zip(rods, lengths, strict=True)), 6)
    result = slenderness(cases, ratios.tolist(), [EXACT], TIMOSHENKO, range(1, MODES + 1), bench)
    _solved(result.study, solved)
    apart = np.abs([result.errors[case, EXACT] for case in cases]).max(axis=0)
    stiffness = [
        max(100 * np.abs(_stiffness_ratios(with_rods(case, ratio)) - 1).max() for case in cases)
        for ratio in ratios.tolist()
    ]
    return Slender(ratios, apart, np.array(stiffness))


def _stiffness_ratios(case: Case) -> Floats:
    """Return the platform's static stiffness by Euler-Bernoulli over that by Timoshenko, (6,).

    Eigenvalues of the pair: the extremes over all directions of load.
    """
    pair = []
    for model in (EXACT, TIMOSHENKO):
        theory = Substructure(PAPER_ELEMENTS, model.name)
        K = theory.matrices(case.mechanism, case.pose)[0].toarray()
        pair.append(np.linalg.inv(np.linalg.inv(K)[-6:, -6:]))
    euler, timoshenko = ((A + A.T) / 2 for A in pair)
    return np.asarray(scipy.linalg.eigh(euler, timoshenko, eigvals_only=True))


def _timed(case: Case, models: Sequence[Named], bench: Bench, solved: list[Row]) -> list[Timed]:
    """Return what every model takes for one pose, all of them in turns; or `UnmeasuredError`."""
    timings = time_ways(bench, [Way(model) for model in models], [case], ROUNDS, MODES)
    for one in timings.timed:
        solved += timed_rows(one, [case], "claims")
    reasons = timings.failures if len(timings.timed) == len(models) else timings.left_out
    _sound(f"{k}: {why}" for k, why in (reasons | timings.failures).items())
    return list(timings.timed)


def times(cases: Cases, bench: Bench, solved: list[Row]) -> dict[str, dict[int, Spent]]:
    """Return what one pose takes without and with multipliers, measured in turns and counted."""
    case, limbs = cases[-1], len(cases[-1].mechanism.limbs)
    kinds = {"paper": Named(PAPER.name, None)} | {
        solver: Named("multipliers", None, (("solver", solver),)) for solver in SOLVERS
    }
    ways = {
        (name, s): replace(kinds[name], elements=s) for s in COST_STEPS for name in FORMULATIONS
    }
    timed = _timed(case, list(ways.values()), bench, solved)
    found: dict[str, dict[int, Spent]] = {name: {} for name in FORMULATIONS}
    for (name, s), one in zip(ways, timed, strict=True):
        found[name][s] = Spent(one.seconds, one.solves, counted(name, s, limbs).flops)
    return found


def fea_times(cases: Cases, bench: Bench, solved: list[Row]) -> dict[str, Spent]:
    """Return what one pose takes by the paper's way and by the stand-in, in turns, and by a solid.

    `Spent.work` are coordinates: those of the paper's way are what it solves for.
    """
    case, solid = cases[-1], solid_truth()
    models = [PAPER, parse(STAND_IN, "reference")]
    timed = _timed(case, models, bench, solved)
    found = {
        model.label: Spent(one.seconds, one.solves, float(one.dofs or 0))
        for model, one in zip(models, timed, strict=True)
    }
    if solid is not None:
        study = bench.run([case], [solid], MODES)
        solved += study.rows()
        modes = study.get(case, solid)
        if modes is not None:
            whole, solve = np.array([modes.seconds]), np.array([modes.solve_seconds])
            found[solid.label] = Spent(whole, solve, float(modes.dofs))
    return found


def maps(cases: Cases, bench: Bench, solved: list[Row]) -> Maps:
    """Return the regular workspace of a case's mechanism and the paper's f1-f3 in it."""
    mechanism, limits = cases[0].mechanism, Limits()
    region, limbs = Region.of(mechanism, limits), len(mechanism.limbs)
    data = whole(region, PAPER, 3, bench)
    _sound(data.answers.failures.values())
    solved += data.rows()
    change, _ = rises(data)
    volumes = {}
    for angle in LIMIT_ANGLES:
        held = Limits(spherical_max=np.radians(angle), revolute_max=np.radians(angle))
        there = region if held == limits else Region.of(mechanism, held)
        volumes[angle] = (there.cone.volume, there.circles.volume)
    return Maps(
        ripple=largest_ripple(data),
        turned=turned(data, limbs),
        period=360 / limbs,
        steps=int(np.isfinite(change).sum()),
        rising=int((change >= 0).sum()),
        z=data.grid.z,
        level=data.frequencies[:, 0, 0, 0],
        limit=float(np.degrees(limits.spherical_max)),
        volumes=volumes,
    )


GROUPS: dict[str, Callable[[Cases, Bench, list[Row]], Any]] = {
    "beams": beams,
    "fea": lambda cases, *how: reference(cases, parse(STAND_IN, "reference"), *how),
    "solid": lambda cases, *how: reference(cases, _solid(), *how),
    "slender": slender,
    "equations": lambda cases, *_: equations(cases),
    "times": times,
    "fea_times": fea_times,
    "maps": maps,
}
"""What measures each group of `Facts`, in the order in which they are measured."""
