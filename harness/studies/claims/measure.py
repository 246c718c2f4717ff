"""Measures the figures that the claims' verdicts rest on, with the bench and other studies."""

import tomllib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.linalg

from analytic import Limits, Pose, Substructure, limbs_at
from harness import published
from harness.bench import Bench, Study
from harness.cases import PRESETS, Case
from harness.presets import LIMB_SOLIDS, PAPER_ELEMENTS, STAND_IN, solid_truth
from harness.studies.claims.equations import equations
from harness.studies.claims.facts import (
    CASES,
    EXACT,
    GROUPS,
    PAPER,
    RAYLEIGH,
    TIMOSHENKO,
    Beams,
    Facts,
    FeaTimes,
    Floats,
    Maps,
    Printed,
    Reference,
    Slender,
    Times,
)
from harness.studies.precision import SOLVERS, timed_rows
from harness.studies.slenderness import with_rods
from harness.studies.workspace import whole
from harness.studies.workspace.checks import largest_ripple, rises, turned
from harness.studies.workspace.map import Region, solve
from harness.timing import Timed, Way, time_ways
from reference_models import Named, UnavailableError, parse

Row = dict[str, Any]

MODES = 6
STEPS = range(1, 9)
ROUNDS = 11
STEADY = 1.5
"""Largest ratio of the quartiles of times that were measured in turns: 1.1 on a machine at rest."""
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
    makers: dict[str, Callable[[], Any]] = {
        "beams": lambda: beams(cases, bench, solved),
        "fea": lambda: reference(cases, parse(STAND_IN, "reference"), bench, solved),
        "solid": lambda: reference(cases, _solid(), bench, solved),
        "slender": lambda: slender(cases, bench, solved),
        "equations": lambda: equations(cases),
        "times": lambda: times(cases[-1], bench, solved),
        "fea_times": lambda: fea_times(cases[-1], bench, solved),
        "maps": lambda: maps(cases[0], bench, solved),
    }
    found: dict[str, Any] = {}
    missing: dict[str, str] = {}
    for group in sorted(groups, key=GROUPS.index):
        try:
            found[group] = makers[group]()
        except (UnavailableError, UnmeasuredError) as error:
            missing[group] = str(error)
    return Facts(printed(), **found), missing, solved


def printed() -> Printed:
    """Return the paper's numbers as they are stored."""
    matrices = tomllib.loads(published.text("equations.toml"))
    return Printed(
        table=published.table1(),
        figure3=published.figure3(),
        cost=published.cost(),
        columns={name: tuple(entry["columns"]) for name, entry in matrices.items()},
        blocks={
            name: {row: tuple((a, b) for a, b in widths) for row, widths in entry["rows"].items()}
            for name, entry in matrices.items()
        },
    )


def _solved(study: Study, solved: list[Row]) -> Study:
    """Return `study`, its rows added to `solved`; raises `UnmeasuredError` if anything failed."""
    solved += study.rows()
    if study.failures:
        reasons = (f"{m.label}: {why}" for (_, m), why in study.failures.items())  # type: ignore[attr-defined]
        raise UnmeasuredError("; ".join(dict.fromkeys(reasons)))
    return study


def beams(cases: Sequence[Case], bench: Bench, solved: list[Row]) -> Beams:
    """Return the theories with and without elements at `cases`, and all readings of the paper.

    As everywhere below, rows of what is solved are added to `solved`.
    """
    models = [*(replace(PAPER, elements=s) for s in STEPS), EXACT, RAYLEIGH, TIMOSHENKO]
    study = _solved(bench.run(cases, [PAPER, *models], MODES), solved)
    hertz = {
        (case.name, model): _paired(study, case, model)[0] for case in cases for model in models
    }
    readings = {}
    for case in PRESETS.values():
        reading = _solved(bench.run([case], [case.theory], MODES), solved)
        readings[case.name] = (
            case.published,
            reading.answers[case, case.theory].frequencies[:MODES],
        )
    # The printed stroke, level: o is as high as a limb's end.
    scan_z = np.linspace(Limits().length_min, Limits().length_max, HEIGHTS)
    scan = {}
    for case in cases:
        poses = Pose(scan_z, case.pose.azimuth, case.pose.tilt)
        answers = solve(PAPER, case.mechanism, poses, MODES, bench)
        if answers.failures:
            raise UnmeasuredError("; ".join(answers.failures.values()))
        solved += answers.rows(PAPER, case.mechanism, poses)
        scan[case.name] = answers.frequencies
    shown = [*PRESETS.values(), *cases]
    lengths = {case.name: limbs_at(case.mechanism, case.pose).lengths for case in shown}
    return Beams(
        elements=tuple(STEPS),
        hertz=hertz,
        readings=readings,
        scan_z=scan_z,
        scan=scan,
        heights={case.name: case.pose.z for case in shown},
        lengths={name: (float(found.min()), float(found.max())) for name, found in lengths.items()},
    )


def _paired(study: Study, case: Case, model: Named) -> tuple[Floats, Floats]:
    """Return f1-f6 and their uncertainty [Hz] in the order of the paper's modes."""
    modes, pairing = study.answers[case, model], study.pairing(case, PAPER, model)
    assert pairing is not None, "both have an answer"
    if pairing.doubtful.any():
        lost = 1 + int(np.argmax(pairing.doubtful))
        raise UnmeasuredError(f"{model.label}: no mode at {case.name} looks like f{lost}")
    own = np.zeros(len(modes.frequencies)) if modes.uncertainty is None else modes.uncertainty
    return modes.frequencies[pairing.partner], own[pairing.partner]


def reference(cases: Sequence[Case], model: Named, bench: Bench, solved: list[Row]) -> Reference:
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


def slender(cases: Sequence[Case], bench: Bench, solved: list[Row]) -> Slender:
    """Return how both theories differ from rods of d/L = `THINNEST` up to the printed ones."""
    rods = [case.mechanism.limbs[0].rod.diameter for case in cases]
    lengths = [limbs_at(case.mechanism, case.pose).lengths.mean() for case in cases]
    ratios = np.geomspace(THINNEST, max(d / L for d, L in zip(rods, lengths, strict=True)), 6)
    first, frequencies, stiffness = np.zeros((3, len(ratios)))
    for k, ratio in enumerate(ratios.tolist()):
        stout = [with_rods(case, ratio) for case in cases]
        study = _solved(bench.run(stout, [EXACT, TIMOSHENKO], MODES), solved)
        for case in stout:
            euler, timoshenko = (
                study.answers[case, model].frequencies[:MODES] for model in (EXACT, TIMOSHENKO)
            )
            apart = 100 * np.abs(euler / timoshenko - 1)
            first[k] = max(first[k], apart[0])
            frequencies[k] = max(frequencies[k], apart.max())
            stiffness[k] = max(stiffness[k], 100 * np.abs(_stiffness_ratios(case) - 1).max())
    return Slender(ratios, first, frequencies, stiffness)


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
    if timings.failures:
        raise UnmeasuredError("; ".join(f"{k}: {why}" for k, why in timings.failures.items()))
    return list(timings.timed)


def times(case: Case, bench: Bench, solved: list[Row]) -> Times:
    """Return times of one pose without and with multipliers, measured in turns."""
    rivals = [Named("multipliers", PAPER_ELEMENTS, (("solver", solver),)) for solver in SOLVERS]
    found = Times(*(one.seconds for one in _timed(case, [PAPER, *rivals], bench, solved)))
    steady(found)
    return found


def steady(found: Times) -> None:
    """Raise `UnmeasuredError` where rounds differ by so much that their median is chance."""
    for rival in (found.null_space, found.saddle_point):
        low, high = np.percentile(found.own / rival, [25, 75])
        if high > STEADY * low:
            raise UnmeasuredError(
                f"the machine is too busy: ratios of times have quartiles {low:.2f} and {high:.2f}"
            )


def fea_times(case: Case, bench: Bench, solved: list[Row]) -> FeaTimes:
    """Return times of one pose by the paper's way and by the stand-in, in turns, and by a solid."""
    stand_in, solid = parse(STAND_IN, "reference"), solid_truth()
    own, beam = _timed(case, [PAPER, stand_in], bench, solved)
    fea = {stand_in.label: beam.seconds}
    if solid is not None:
        study = bench.run([case], [solid], MODES)
        solved += study.rows()
        modes = study.get(case, solid)
        if modes is not None:
            fea[solid.label] = np.array([modes.build_seconds + modes.solve_seconds])
    return FeaTimes(own.seconds, fea)


def maps(case: Case, bench: Bench, solved: list[Row]) -> Maps:
    """Return the regular workspace of a case's mechanism and the paper's f1-f3 in it."""
    limits, limbs = Limits(), len(case.mechanism.limbs)
    region = Region.of(case.mechanism, limits)
    data = whole(region, PAPER, 3, bench)
    if data.answers.failures:
        raise UnmeasuredError("; ".join(data.answers.failures.values()))
    solved += data.rows()
    change, _ = rises(data)
    volumes = {}
    for angle in LIMIT_ANGLES:
        held = Limits(spherical_max=np.radians(angle), revolute_max=np.radians(angle))
        there = region if held == limits else Region.of(case.mechanism, held)
        volumes[angle] = (there.cone.volume, there.circles.volume)
    return Maps(
        model=PAPER.label,
        ripple=largest_ripple(data),
        turned=turned(data, limbs),
        period=360 / limbs,
        steps=int(np.isfinite(change).sum()),
        rising=int((change >= 0).sum()),
        z=data.grid.z,
        level=data.frequencies[:, 0, 0, 0],
        volumes=volumes,
        limit=float(np.degrees(limits.spherical_max)),
    )
