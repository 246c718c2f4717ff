"""The error, split into its causes: parts that add up to the paper's one "error (%)"."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from analytic import InputError
from analytic.model import Model
from analytic.pairing import pair
from analytic.theory import BEAMS
from harness.bench import Bench, Study
from harness.cases import Case
from harness.causes import effects, exact_chain
from harness.compare import at_most, case_notes, cells, failure_notes, pairing_notes, span
from harness.figures import COLOURS, MARKERS
from harness.plan import Plan
from harness.presets import PAPER_ELEMENTS
from harness.request import Request
from harness.result import Result
from harness.studies.refinement import Ladder, ladder, verified
from harness.tables import Cell, Number, Table
from reference_models import Named, parse

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
DEFAULTS = {"elements": "1-4"}
ELEMENTS = "number of elements"
"""The first part: what vanishes as s grows."""


@dataclass(frozen=True)
class Budget(Result):
    """Error of a theory with s elements against a reference, in parts.

    Attributes:
        study: behind it.
        theory: whatever its elements.
        reference: what the error is against.
        elements: s.
        parts: their names in order.
        shares: by case, shape (len(elements), len(parts), count) [percentage points of the
            reference's frequency], whose sum over the parts is the error; NaN against 0 Hz.
        bands: by case and simulator on the way, the reference last, its GCI, shape (count,) [%];
            NaN where it has no three meshes.
        shown: mode numbers from 1.
        notes: what must be known of the numbers.
    """

    study: Study
    theory: Named
    reference: Named
    elements: tuple[int, ...]
    parts: tuple[str, ...]
    shares: Mapping[Case, Array]
    bands: Mapping[Case, Mapping[Named, Array]]
    shown: tuple[int, ...]
    notes: tuple[str, ...]

    @property
    def studies(self) -> tuple[Study, ...]:
        """What was solved for it."""
        return (self.study,)

    def to_frame(self) -> "pd.DataFrame":
        """Return one row a case, s, mode and part, and the reference's own GCI."""
        import pandas as pd

        return pd.DataFrame([
            {
                "case": case.name,
                "theory": self.theory.name,
                "reference": self.reference.label,
                "elements": s,
                "mode": i,
                "part": part,
                "share_percent": table[k, p, i - 1],
                "reference_gci_percent": self.bands[case][self.reference][i - 1],
            }
            for case, table in self.shares.items()
            for k, s in enumerate(self.elements)
            for i in self.shown
            for p, part in enumerate(self.parts)
        ])  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return the parts, their sum and the reference's own GCI, in percentage points."""
        pick = [i - 1 for i in self.shown]
        rows: list[tuple[Cell, ...]] = []
        for case, shares in self.shares.items():
            for s, table in zip(self.elements, shares, strict=True):
                for part, share in zip(self.parts, table, strict=True):
                    rows.append((case.name, s, part, *cells(share[pick], 3, signed=True)))
                total = table.sum(axis=0)
                rows.append((case.name, s, "total error", *cells(total[pick], 3, signed=True)))
            for model, own in self.bands[case].items():
                known = ["not known" if np.isnan(b) else Number(float(b), 3) for b in own[pick]]
                whose = "reference's" if model == self.reference else f"{model.label}'s"
                rows.append((case.name, "", f"{whose} own GCI, +-", *known))
        title = f"Error of {self.theory.name}@s against {self.reference.label}, by cause [points]"
        notes = (*self.notes, *case_notes(self.study.cases))
        columns = ("Case", "s", "Part", *(f"f{i}" for i in self.shown))
        return {"": Table(title, columns, tuple(rows), notes)}

    def figures(self) -> "dict[str, Figure]":
        """Return the bars, and Fig. 3 with the floor that no number of elements can cross."""
        if not self.shares:
            return {}
        return {"": budget_figure(self), "-floor": floor_figure(self)}

    def sentences(self) -> list[str]:
        """Return the range of each part over cases, with the paper's number of elements."""
        if not self.shares or PAPER_ELEMENTS not in self.elements:
            return []
        k = self.elements.index(PAPER_ELEMENTS)
        pick = np.array(self.shown) - 1
        shares = np.array([table[k][:, pick] for table in self.shares.values()])
        # The paper's modes come in two kinds: the platform moves, or the limbs bend.
        halves = {
            _modes(self.shown, half): shares[:, :, half]
            for half in (np.array(self.shown) <= 3, np.array(self.shown) > 3)
            if half.any()
        }
        parts = "; ".join(
            part
            + " "
            + " and ".join(f"{span(of[:, p], signed=True)} on {on}" for on, of in halves.items())
            for p, part in enumerate(self.parts)
        )
        ours = replace(self.theory, elements=PAPER_ELEMENTS).label
        own = np.array([bands[self.reference][pick] for bands in self.bands.values()])
        known = "not known" if np.isnan(own).any() else at_most(float(own.max()))
        return [
            f"{ours} against {self.reference.label}, by cause: {parts}. The reference's own GCI: "
            f"{known}."
        ]


def _modes(shown: Sequence[int], which: NDArray[np.bool_]) -> str:
    found = np.array(shown)[which]
    return f"f{found[0]}" if len(found) == 1 else f"f{found[0]}-f{found[-1]}"


def solids(reference: Named) -> list[Named]:
    """Return the reference without its assumption where that can run, then the reference."""
    info = reference.info()
    if not info.relaxed:
        return [reference]
    relaxed = parse(info.relaxed, "reference")
    return [reference] if relaxed.info().missing else [relaxed, reference]


def meshes(model: Named) -> Ladder:
    """Return the three meshes that the GCI of NAME@COARSE+FINE is read from; else none.

    These two and half of COARSE; none either where that is fewer elements than the model can have.
    """
    if not isinstance(model.elements, tuple):
        return ()
    coarse, fine = model.elements
    try:
        return ladder(model, (coarse // 2, coarse, fine))
    except InputError:
        return ()


def budget(
    cases: Sequence[Case],
    theory: Named,
    elements: Sequence[int],
    reference: Named,
    shown: Sequence[int],
    bench: Bench,
) -> Budget:
    """Return the budget of `theory` with each of `elements` against `reference`.

    A part is 100 (f_a - f_b) / f_reference between neighbours of the chain: theory with s elements,
    theory without, each richer beam theory without, the reference without its assumption,
    reference. Every mode is followed by its shape.
    """
    chain, simulators = exact_chain(theory), solids(reference)
    discrete = [replace(theory, elements=s) for s in elements]
    ladders = {model: steps for model in simulators if (steps := meshes(model))}
    refined = [mesh for steps in ladders.values() for mesh in steps]
    study = bench.run(cases, [*simulators, *chain, *discrete, *refined], max(shown))
    shares, bands, notes = {}, {}, []
    seen = {model: verified(study, steps) for model, steps in ladders.items()}
    for case in study.complete(*simulators, *chain, *discrete):
        shares[case] = np.array([
            _shares(study, case, [mesh, *chain, *simulators]) for mesh in discrete
        ])  # fmt: skip
        for mesh in discrete:
            pairing = study.pairing(case, mesh, reference)
            assert pairing is not None, "both have an answer"
            notes += pairing_notes(case, mesh, reference, pairing, [i - 1 for i in shown])
        bands[case] = {model: np.full(study.count, math.nan) for model in simulators}
        for model, steps in ladders.items():
            pairing = study.pairing(case, discrete[-1], steps[-1])
            remarks: dict[str, list[str]] = {}
            for i, partner in enumerate(() if pairing is None else pairing.partner.tolist()):
                one = seen[model].get((case, partner + 1))
                if one is None:
                    continue
                bands[case][model][i] = one.band
                if one.say.remark and i + 1 in shown:
                    remarks.setdefault(one.say.remark, []).append(f"f{i + 1}")
            notes += [
                f"{case.name}: GCI of {model.label}: {', '.join(modes)} {remark}"
                for remark, modes in remarks.items()
            ]
    for model, steps in ladders.items():
        numbers = ", ".join(str(mesh.elements) for mesh in steps)
        notes.append(f"GCI of {model.label}: grid convergence index from {numbers} elements")
    if len(simulators) > 1:
        notes.insert(
            0, f"{reference.info().assumption}: {simulators[0].name} is without, {reference.name} "
            "has it",
        )  # fmt: skip
    return Budget(
        study, theory, reference, tuple(elements), _parts(chain, simulators), shares, bands,
        tuple(shown), (*notes, *failure_notes(study)),
    )  # fmt: skip


def _parts(chain: list[Named], simulators: list[Named]) -> tuple[str, ...]:
    """Return what each step of the chain is called."""
    richest = BEAMS[chain[-1].name] if chain else "theory"
    last = [f"{richest} to reference"]
    if len(simulators) > 1:
        last = ["three-dimensional effects", simulators[-1].info().assumption]
    return (*((ELEMENTS,) if chain else ()), *effects(chain), *last)


def _shares(study: Study, case: Case, chain: Sequence[Model]) -> Array:
    """Return the steps down the chain, (len(chain) - 1, count) [% of its last frequency]."""
    start = study.answers[case, chain[0]].first(study.count)
    values = [start.frequencies]
    for model in chain[1:]:
        modes = study.answers[case, model]
        values.append(modes.frequencies[pair(start, modes, case.mechanism, case.pose).partner])
    steps = -100 * np.diff(np.array(values), axis=0)
    return np.divide(steps, values[-1], out=np.full_like(steps, np.nan), where=values[-1] != 0)


def run(request: Request, bench: Bench) -> Budget:
    """Return the budget of the theory against the first reference: parts add up to the error."""
    theory, reference = request.theory, request.references[0]
    return budget(request.cases, theory, request.steps, reference, request.shown, bench)


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: against beams that share the theory, and against solids."""
    return {
        "budget" if reference == plan.solid else f"budget-{reference.name}": plan.request(
            references=(reference,), elements=(1, 2, 3, 4)
        )
        for reference in plan.against
    }


def budget_figure(result: Budget) -> "Figure":
    """Return stacked bars, one a mode and s; a panel a case. The line is the reference's GCI."""
    from matplotlib.figure import Figure

    pick, shown = [i - 1 for i in result.shown], result.shown
    figure = Figure(figsize=(6.4 * len(result.shares), 4.2), layout="constrained")
    panels = figure.subplots(1, len(result.shares), squeeze=False, sharey=True)[0]
    width = 0.8 / len(result.elements)
    for letter, (axes, (case, shares)) in enumerate(
        zip(panels, result.shares.items(), strict=True)
    ):
        known = np.nan_to_num(shares[:, :, pick])
        for k, table in enumerate(known):
            where = np.arange(len(shown)) + (k - (len(result.elements) - 1) / 2) * width
            up, down = np.zeros(len(shown)), np.zeros(len(shown))
            for p, (part, share) in enumerate(zip(result.parts, table, strict=True)):
                bottom = np.where(share >= 0, up, down)
                axes.bar(where, share, 0.9 * width, bottom=bottom, color=COLOURS[p],
                         label=part if k == 0 else None)  # fmt: skip
                up, down = up + np.maximum(share, 0), down + np.minimum(share, 0)
            for x, top in zip(where, up, strict=True):
                axes.annotate(f"{result.elements[k]}", (x, top), xytext=(0, 2), ha="center",
                              textcoords="offset points", fontsize=7)  # fmt: skip
        own = result.bands[case][result.reference][pick]
        axes.errorbar(where + 0.75 * width, known[-1].sum(axis=0), own, fmt="none", ecolor="0.3",
                      capsize=2)  # fmt: skip
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


def floor_figure(result: Budget) -> "Figure":
    """Return Fig. 3 again, with the floor of each mode that no number of elements can cross."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.2 * len(result.shares), 4.2), layout="constrained")
    panels = figure.subplots(1, len(result.shares), squeeze=False, sharey=True)[0]
    for letter, (axes, (case, table)) in enumerate(zip(panels, result.shares.items(), strict=True)):
        for i in result.shown:
            style = {"color": COLOURS[(i - 1) % 6], "lw": 1.2}
            axes.plot(result.elements, table.sum(axis=1)[:, i - 1], marker=MARKERS[(i - 1) % 6],
                      markersize=9 - 4 * ((i - 1) % 2), label=f"$e_{i}$", **style)  # fmt: skip
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
