"""Measures the figures that the claims' verdicts rest on, with the bench's own modules."""

import tomllib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.linalg

from analytic import Limits, Pose, Substructure, condensed_frequencies, limbs_at
from harness import published
from harness.cases import PRESETS, Case
from harness.claims.equations import equations
from harness.claims.facts import (
    CASES,
    GROUPS,
    PAPER,
    THEORY,
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
from harness.models import PAPER_ELEMENTS, Spec, parse
from harness.options import STAND_IN
from harness.precision.cost import Cost, measure
from harness.precision.solved import Solved
from harness.precision.ways import solid_truth
from harness.run import MAP, rows, run
from harness.slenderness import THEORIES, with_rods
from harness.workspace.checks import ripple, rises, turned
from harness.workspace.map import Grid, Region, workspace_map
from harness.workspace.rows import history_rows
from reference_models import UnavailableError
from reference_models.protocol import find

Done = Callable[[str], None]
Row = dict[str, Any]

SOLIDS = ("ngsolve-solid", "calculix-solid")
"""Solid rods, the quicker first: whichever can run here."""
MODES = 6
STEPS = range(1, 9)
ROUNDS = 11
THINNEST = 0.02
LIMIT_ANGLES = (30.0, 45.0, 60.0)
SHAPE = (36, 8)
"""Azimuths and tilts of a layer."""


def gather(
    groups: Iterable[str], done: Done = lambda _: None
) -> tuple[Facts, dict[str, str], list[Row]]:
    """Return the facts of `groups`, why a group could not be measured, and all that was solved.

    The last as rows for the history.
    """
    cases = [PRESETS[name] for name in CASES]
    solved: list[Row] = []
    makers: dict[str, Callable[[], Any]] = {
        "beams": lambda: beams(cases, solved),
        "fea": lambda: reference(cases, parse(STAND_IN, "reference"), solved),
        "solid": lambda: reference(cases, parse(_solid(), "reference"), solved),
        "slender": lambda: slender(cases, solved),
        "equations": lambda: equations(cases),
        "times": lambda: times(solved),
        "fea_times": lambda: fea_times(cases[0], solved),
        "maps": lambda: maps(cases[0], solved),
    }
    found: dict[str, Any] = {}
    missing: dict[str, str] = {}
    for group in sorted(groups, key=GROUPS.index):
        try:
            found[group] = makers[group]()
        except (UnavailableError, UnmeasuredError) as error:
            missing[group] = str(error)
        done(group)
    return Facts(printed(), **found), missing, solved


class UnmeasuredError(RuntimeError):
    """A simulator that is there failed, with the reason."""


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


def beams(cases: Sequence[Case], solved: list[Row]) -> Beams:
    """Return the theories with and without elements at `cases`, and all readings of the paper.

    As everywhere below, rows of what is solved are added to `solved`.
    """
    exact = [Spec(name, None) for name in (THEORY, "rayleigh", "timoshenko")]
    theory = Spec(THEORY, PAPER_ELEMENTS)
    specs = [*(Spec(THEORY, s) for s in STEPS), *exact]
    study = run(cases, [theory, *specs], MODES)
    solved += rows(study)
    hertz = {}
    for case in study.cases:
        for spec in study.specs:
            pairing = study.pairing(case, theory, spec)
            assert pairing is not None, "analytic models do not fail"
            hertz[case.name, spec.label] = study.modes[case.name, spec.label].frequencies[
                pairing.partner
            ]
    readings = {}
    for case in PRESETS.values():
        reading = run([case], [parse(case.model, "model")], MODES)
        solved += rows(reading)
        (modes,) = reading.modes.values()
        readings[case.name] = (case.published, modes.frequencies[:MODES])
    # The printed stroke, level: o is as high as a limb's end.
    scan_z = np.linspace(Limits().length_min, Limits().length_max, 801)
    scan = {
        case.name: condensed_frequencies(
            case.mechanism, Pose(scan_z, case.pose.azimuth, case.pose.tilt), PAPER_ELEMENTS
        )
        for case in cases
    }
    for case in cases:
        for z, found in zip(scan_z.tolist(), scan[case.name], strict=True):
            there = Case(MAP, case.mechanism, replace(case.pose, z=z), case.note)
            solved += Solved(theory, there, "condensed").rows(found, None)
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


def reference(cases: Sequence[Case], spec: Spec, solved: list[Row]) -> Reference:
    """Return a simulator's frequencies, paired by shape, or raise `UnmeasuredError`."""
    theory = parse(PAPER, "model")
    study = run(cases, [theory, spec], MODES)
    solved += rows(study)
    if study.failures:
        raise UnmeasuredError(
            "; ".join(f"{label}: {why}" for (_, label), why in study.failures.items())
        )
    hertz, uncertainty = {}, {}
    for case in study.cases:
        modes, pairing = study.modes[case.name, spec.label], study.pairing(case, theory, spec)
        assert pairing is not None, "both have an answer"
        if pairing.doubtful.any():
            lost = 1 + int(np.argmax(pairing.doubtful))
            raise UnmeasuredError(f"{spec.label}: no mode at {case.name} looks like f{lost}")
        hertz[case.name] = modes.frequencies[pairing.partner]
        own = np.zeros(len(modes.frequencies)) if modes.uncertainty is None else modes.uncertainty
        uncertainty[case.name] = own[pairing.partner]
    return Reference(spec.label, hertz, uncertainty)


def _solid() -> str:
    """Return the first of `SOLIDS` that can run here."""
    reasons = {name: find(name).info().missing for name in SOLIDS}
    for name, why in reasons.items():
        if not why:
            return name
    raise UnavailableError("; ".join(f"{name}: {why}" for name, why in reasons.items()))


def slender(cases: Sequence[Case], solved: list[Row]) -> Slender:
    """Return how both theories differ from rods of d/L = `THINNEST` up to the printed ones."""
    rods = [case.mechanism.limbs[0].rod.diameter for case in cases]
    lengths = [limbs_at(case.mechanism, case.pose).lengths.mean() for case in cases]
    ratios = np.geomspace(THINNEST, max(d / L for d, L in zip(rods, lengths, strict=True)), 6)
    first, frequencies, stiffness = np.zeros((3, len(ratios)))
    for k, ratio in enumerate(ratios.tolist()):
        for case in (with_rods(case, ratio) for case in cases):
            pair = [
                condensed_frequencies(case.mechanism, case.pose, None, beam=name, count=MODES)
                for name in THEORIES
            ]
            for name, found in zip(THEORIES, pair, strict=True):
                solved += Solved(Spec(name, None), case, "condensed").rows(found, None)
            euler, timoshenko = pair
            apart = 100 * np.abs(euler / timoshenko - 1).ravel()
            first[k] = max(first[k], apart[0])
            frequencies[k] = max(frequencies[k], apart.max())
            apart = 100 * np.abs(_stiffness_ratios(case) - 1)
            stiffness[k] = max(stiffness[k], apart.max())
    return Slender(ratios, first, frequencies, stiffness)


def _stiffness_ratios(case: Case) -> Floats:
    """Return the platform's static stiffness by Euler-Bernoulli over that by Timoshenko, (6,).

    Eigenvalues of the pair: the extremes over all directions of load.
    """
    pair = []
    for name in THEORIES:
        K = Substructure(PAPER_ELEMENTS, name).matrices(case.mechanism, case.pose)[0].toarray()
        flexibility = np.linalg.inv(K)[-6:, -6:]
        pair.append(np.linalg.inv(flexibility))
    euler, timoshenko = ((A + A.T) / 2 for A in pair)
    return np.asarray(scipy.linalg.eigh(euler, timoshenko, eigvals_only=True))


def times(solved: list[Row]) -> Times:
    """Return times of one pose without and with multipliers, measured in turns."""
    cost = measure([PAPER_ELEMENTS], [], [1], ROUNDS)
    solved += cost.rows
    timed = _timed(cost)
    return Times(
        timed["substructure, dense"],
        timed["multipliers, null-space"],
        timed["multipliers, saddle-point"],
    )


def fea_times(case: Case, solved: list[Row]) -> FeaTimes:
    """Return times of one pose by the paper's way and by the stand-in, in turns, and by a solid."""
    cost = measure([PAPER_ELEMENTS], [STAND_IN], [1], ROUNDS)
    solved += cost.rows
    if cost.stand_in is None:
        raise UnmeasuredError("; ".join(cost.failures.values()))
    fea = {cost.stand_in.model: cost.stand_in.seconds}
    solid = solid_truth()
    if solid is not None:
        study = run([case], [solid], MODES)
        solved += rows(study)
        modes = study.get(case, solid)
        if modes is not None:
            fea[solid.label] = np.array([modes.build_seconds + modes.solve_seconds])
    return FeaTimes(_timed(cost)["substructure, dense"], fea)


def _timed(cost: Cost) -> dict[str, Floats]:
    return {t.model: t.seconds for t in cost.elements if t.size == PAPER_ELEMENTS}


def maps(case: Case, solved: list[Row]) -> Maps:
    """Return the regular workspace of a case's mechanism and the paper's f1-f3 in it."""
    limits, spec = Limits(), Spec(THEORY, PAPER_ELEMENTS)
    region = Region.of(case.mechanism, limits)
    data = workspace_map(region, Grid.of(region, region.circles.z, *SHAPE), spec, 3)
    solved += history_rows(data)
    change, _ = rises(data)
    rings = ripple(data)[:, 1:]  # a level platform has no azimuth
    whole = np.isfinite(rings).all(axis=-1)
    volumes = {}
    for angle in LIMIT_ANGLES:
        held = Limits(spherical_max=np.radians(angle), revolute_max=np.radians(angle))
        there = region if held == limits else Region.of(case.mechanism, held)
        volumes[angle] = (there.cone.volume, there.circles.volume)
    return Maps(
        ripple=rings[whole].max(axis=0),
        turned=turned(data, len(case.mechanism.limbs)),
        period=360 / len(case.mechanism.limbs),
        steps=int(np.isfinite(change).sum()),
        rising=int((change >= 0).sum()),
        z=data.grid.z,
        level=data.frequencies[:, 0, 0, 0],
        volumes=volumes,
        limit=float(np.degrees(limits.spherical_max)),
    )
