"""The error, split into its causes: parts that add up to the paper's one "error (%)"."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from analytic import InputError
from analytic.pairing import pair
from analytic.theory import BEAMS
from harness.cases import Case
from harness.compare import case_notes, failure_notes, pairing_notes
from harness.figures import COLOURS, MARKERS
from harness.models import Spec, parse
from harness.precision.ways import theory_of
from harness.refinement import Seen, ladder, verified
from harness.run import Study, run
from harness.tables import Cell, Number, Table
from reference_models.protocol import find

Array = NDArray[np.float64]
CHAIN = ("euler-bernoulli", "rayleigh", "timoshenko")
"""Beam theories from the poorest to the richest; each adds one effect."""
RIGID, AVERAGED = "3-D elasticity, rigid end faces", "ngsolve-averaged"
EFFECTS = {
    ("euler-bernoulli", "rayleigh"): "rotary inertia",
    ("rayleigh", "timoshenko"): "shear",
}


@dataclass(frozen=True)
class Budget:
    """Error of a theory with s elements against a reference, in parts.

    Attributes: `study` behind it; `theory`, whatever its elements; `reference`; `elements` s;
    `parts`, their names in order; `shares` by case name, shape (len(elements), len(parts), count)
    [percentage points of the reference's frequency], whose sum over the parts is the error;
    `uncertainty`, the GCI by case name and simulator on the way, the reference last, shape (count,)
    [%], NaN where it has no three meshes.
    """

    study: Study
    theory: Spec
    reference: Spec
    elements: tuple[int, ...]
    parts: tuple[str, ...]
    shares: dict[str, Array]
    uncertainty: dict[str, dict[str, Array]]
    notes: tuple[str, ...]


def exact_chain(theory: Spec) -> list[Spec]:
    """Return the exact models from the theory's own to Timoshenko's."""
    return [replace(theory, name=n, elements=None) for n in CHAIN[CHAIN.index(theory.name) :]]


def between(reference: Spec) -> list[Spec]:
    """Return the solid that parts three-dimensional effects from end faces, where it can run.

    A solid reference holds its end faces rigid; the one between lets them warp.
    """
    theory = "" if reference.analytic else theory_of(reference)
    if theory != RIGID or find(AVERAGED).info().missing:
        return []
    return [parse(AVERAGED, "reference")]


def meshes(reference: Spec) -> list[Spec]:
    """Return the three meshes that the GCI of NAME@COARSE+FINE is read from; else none.

    None either where half of COARSE is fewer elements than the model can have.
    """
    if not isinstance(reference.elements, tuple):
        return []
    found = ladder(reference, None)
    try:
        for mesh in found:
            mesh.build()
    except InputError:
        return []
    return found


def models(theory: Spec, elements: Sequence[int], reference: Spec) -> list[Spec]:
    """Return all that `budget` solves."""
    simulators = [*between(reference), reference]
    refined = [mesh for spec in simulators for mesh in meshes(spec)]
    coarse = [replace(theory, elements=s) for s in elements]
    return list(dict.fromkeys([*simulators, *exact_chain(theory), *coarse, *refined]))


def budget(
    cases: Sequence[Case],
    theory: Spec,
    elements: Sequence[int],
    reference: Spec,
    count: int,
    done: Callable[[str], None] = lambda _: None,
) -> Budget:
    """Return the budget of `theory` with each of `elements` against `reference`.

    A part is 100 (f_a - f_b) / f_reference between neighbours of the chain: theory with s elements,
    theory without, each richer beam theory without, for solids one with warping end faces,
    reference. Every mode is followed by its shape.
    """
    chain, solids = exact_chain(theory), between(reference)
    discrete = [replace(theory, elements=s) for s in elements]
    study = run(cases, models(theory, elements, reference), count, done)
    effects = [EFFECTS[a.name, b.name] for a, b in pairwise(chain)]
    last = ["three-dimensional effects", "rigid end faces"]
    if not solids:
        last = [f"{BEAMS[chain[-1].name]} to reference"]
    parts = ("number of elements", *effects, *last)
    shares: dict[str, Array] = {}
    uncertainty: dict[str, dict[str, Array]] = {}
    notes: list[str] = []
    simulators = [*solids, reference]
    seen = {spec.label: verified(study, meshes(spec)) for spec in simulators if meshes(spec)}
    for case in cases:
        if any(study.get(case, spec) is None for spec in (reference, *solids)):
            continue
        table = np.empty((len(discrete), len(parts), count))
        for k, mesh in enumerate(discrete):
            start = study.modes[case.name, mesh.label].first(count)
            values = [start.frequencies]
            for spec in (*chain, *simulators):
                modes = study.modes[case.name, spec.label]
                partner = pair(start, modes, case.mechanism, case.pose).partner
                values.append(modes.frequencies[partner])
            table[k] = -100 * np.diff(np.array(values), axis=0) / values[-1]
            pairing = study.pairing(case, mesh, reference)
            assert pairing is not None, "both have an answer"
            notes += pairing_notes(case, mesh, reference, pairing, range(count))
        shares[case.name] = table
        uncertainty[case.name] = {}
        for spec in simulators:
            own, remarks = _gci(study, case, discrete[-1], spec, seen.get(spec.label, {}))
            uncertainty[case.name][spec.label] = own
            notes += remarks
    for spec in simulators:
        if meshes(spec):
            numbers = ", ".join(str(mesh.elements) for mesh in meshes(spec))
            notes.append(f"GCI of {spec.label}: grid convergence index from {numbers} elements")
    notes += failure_notes(study)
    return Budget(
        study, theory, reference, tuple(elements), parts, shares, uncertainty, tuple(notes)
    )


def _gci(
    study: Study, case: Case, theory: Spec, spec: Spec, seen: dict[tuple[str, int], Seen]
) -> tuple[Array, list[str]]:
    """Return the GCI [%] of each mode of `theory` as `spec` has it, and what warns of it."""
    own = np.full(study.count, np.nan)
    remarks: dict[str, list[str]] = {}
    finest = meshes(spec)[-1:]
    pairing = study.pairing(case, theory, finest[0]) if finest else None
    partners = [] if pairing is None else pairing.partner.tolist()
    for i, partner in enumerate(partners):
        if (case.name, partner) in seen:
            values, found = seen[case.name, partner]
            own[i] = 100 * found.gci / values[-1]
            if found.remark:
                remarks.setdefault(found.remark, []).append(f"f{i + 1}")
    notes = [
        f"{case.name}: GCI of {spec.label}: {', '.join(names)} {remark}"
        for remark, names in remarks.items()
    ]
    return own, notes


def budget_table(result: Budget, shown: Sequence[int]) -> Table:
    """Return the parts, their sum and the reference's own GCI, in percentage points."""
    rows: list[tuple[Cell, ...]] = []
    for case in result.study.cases:
        if case.name not in result.shares:
            continue
        for s, table in zip(result.elements, result.shares[case.name], strict=True):
            for part, share in zip(result.parts, table, strict=True):
                rows.append((case.name, s, part, *(Number(share[i - 1], 3, True) for i in shown)))
            total = table.sum(axis=0)
            rows.append(
                (case.name, s, "total error", *(Number(total[i - 1], 3, True) for i in shown))
            )
        for label, own in result.uncertainty[case.name].items():
            cells = ["not known" if np.isnan(own[i - 1]) else Number(own[i - 1], 3) for i in shown]
            whose = "reference's" if label == result.reference.label else f"{label}'s"
            rows.append((case.name, "", f"{whose} own GCI, +-", *cells))
    title = f"Error of {result.theory.name}@s against {result.reference.label}, by cause [points]"
    notes = (*result.notes, *case_notes(result.study.cases))
    if "rigid end faces" in result.parts:
        notes = (f"end faces: {AVERAGED} lets them warp, {result.reference.name} does not", *notes)
    return Table(title, ("Case", "s", "Part", *(f"f{i}" for i in shown)), tuple(rows), notes)


def budget_figure(result: Budget, shown: Sequence[int]) -> Figure:
    """Return stacked bars, one a mode and s; a panel a case. The line is the reference's GCI."""
    cases = [case for case in result.study.cases if case.name in result.shares]
    figure = Figure(figsize=(6.4 * len(cases), 4.2), layout="constrained")
    panels = figure.subplots(1, len(cases), squeeze=False, sharey=True)[0]
    width = 0.8 / len(result.elements)
    for letter, (axes, case) in enumerate(zip(panels, cases, strict=True)):
        for k, table in enumerate(result.shares[case.name]):
            where = np.arange(len(shown)) + (k - (len(result.elements) - 1) / 2) * width
            up, down = np.zeros(len(shown)), np.zeros(len(shown))
            for p, part in enumerate(result.parts):
                share = table[p, [i - 1 for i in shown]]
                bottom = np.where(share >= 0, up, down)
                axes.bar(where, share, 0.9 * width, bottom=bottom, color=COLOURS[p],
                         label=part if k == 0 else None)  # fmt: skip
                up, down = up + np.maximum(share, 0), down + np.minimum(share, 0)
            for x, top in zip(where, up, strict=True):
                axes.annotate(f"{result.elements[k]}", (x, top), xytext=(0, 2), ha="center",
                              textcoords="offset points", fontsize=7)  # fmt: skip
        own = result.uncertainty[case.name][result.reference.label][[i - 1 for i in shown]]
        total = result.shares[case.name][-1].sum(axis=0)[[i - 1 for i in shown]]
        axes.errorbar(where + 0.75 * width, total, own, fmt="none", ecolor="0.3", capsize=2)
        axes.set_xticks(range(len(shown)), [f"$f_{{{i}}}$" for i in shown])
        axes.set_title(f"({chr(97 + letter)}) {case.name}", fontsize=11)
        axes.axhline(0, color="0.4", lw=0.8)
    panels[0].set_ylabel("share of the error [percentage points]")
    panels[0].legend(fontsize=8, loc="upper left")
    figure.suptitle(
        f"{result.theory.name}@s against {result.reference.label}; on each bar: s; "
        "beside it: the reference's own GCI", fontsize=10,
    )  # fmt: skip
    return figure


def floor_figure(result: Budget, shown: Sequence[int]) -> Figure:
    """Return Fig. 3 again, with the floor of each mode that no number of elements can cross."""
    cases = [case for case in result.study.cases if case.name in result.shares]
    figure = Figure(figsize=(5.2 * len(cases), 4.2), layout="constrained")
    panels = figure.subplots(1, len(cases), squeeze=False, sharey=True)[0]
    for letter, (axes, case) in enumerate(zip(panels, cases, strict=True)):
        table = result.shares[case.name]
        for i in shown:
            style = {"color": COLOURS[(i - 1) % 6], "lw": 1.2}
            size = 9 - 4 * ((i - 1) % 2)
            axes.plot(result.elements, table.sum(axis=1)[:, i - 1], marker=MARKERS[(i - 1) % 6],
                      markersize=size, label=f"$e_{i}$", **style)  # fmt: skip
            axes.axhline(table[-1, 1:, i - 1].sum(), ls="--", alpha=0.6, **style)
        axes.set_xlabel("number of elements $s$")
        axes.set_xticks(result.elements)
        axes.set_title(f"({chr(97 + letter)}) {case.name}", fontsize=11)
        axes.grid(alpha=0.25)
    panels[0].set_ylabel("relative error [%]")
    panels[-1].legend(fontsize=9)
    figure.suptitle(
        f"{result.theory.name}@s against {result.reference.label}; dashed: the floor, without "
        "elements", fontsize=10,
    )  # fmt: skip
    return figure
