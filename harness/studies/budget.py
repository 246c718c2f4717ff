"""The error, split into its causes: parts that add up to the paper's one "error (%)"."""

from collections.abc import Iterator
from functools import cached_property
from typing import Any

import numpy as np

from analytic import InputError
from analytic.theory import BEAMS
from harness.bench import Bench
from harness.case import Case
from harness.causes import effects, exact_chain
from harness.compare import (
    AgainstElements,
    at,
    case_notes,
    cells,
    failure_notes,
    match,
    pairing_notes,
    percent,
    span,
)
from harness.figures import COLOURS, panels
from harness.plan import Plan
from harness.presets import PAPER_ELEMENTS
from harness.request import Request
from harness.signatures import Array, Figure
from harness.studies.refinement import Ladder, Verification, ladder, verified
from harness.tables import Cell, Table
from reference_models import Named, parse

DEFAULTS = {"elements": "1-4"}
ELEMENTS = "number of elements"
"""The first part: what vanishes as s grows."""


class Budget(AgainstElements):
    """The error of a theory, in parts.

    A part is 100 (f_a - f_b) / f_reference between neighbours of a chain: theory with s elements,
    theory without, each richer beam theory without, the reference without its assumption,
    reference. Every mode is followed by its shape.
    """

    @cached_property
    def chain(self) -> tuple[Named, ...]:
        """The steps after the theory with elements: exact models, then `simulators`."""
        return (*exact_chain(self.theory), *self.simulators)

    @cached_property
    def simulators(self) -> tuple[Named, ...]:
        """The last of the chain."""
        return solids(self.reference)

    @cached_property
    def ladders(self) -> dict[Named, Ladder]:
        """The meshes of those simulators that have three."""
        return {model: steps for model in self.simulators if (steps := meshes(model))}

    @property
    def parts(self) -> tuple[str, ...]:
        """What each step of the chain is called."""
        exact = list(self.chain[: -len(self.simulators)])
        richest = BEAMS[exact[-1].name] if exact else "theory"
        last = [f"{richest} to reference"]
        if len(self.simulators) > 1:
            last = ["three-dimensional effects", self.reference.info().assumption]
        return (*((ELEMENTS,) if exact else ()), *effects(exact), *last)

    @cached_property
    def shares(self) -> dict[Case, Array]:
        """Parts by case, (len(elements), parts, count) [points of the reference's frequency].

        Their sum over the parts is the error; NaN against 0 Hz. Of cases without a failure.
        """
        cases = self.study.complete(*self.chain, *self.meshes)
        return {
            case: np.array([self._shares(case, mesh) for mesh in self.meshes]) for case in cases
        }

    def _shares(self, case: Case, mesh: Named) -> Array:
        found = [match(self.study, case, mesh, model) for model in self.chain]
        values = np.array([one.against for one in found if one])
        steps = -100 * np.diff([self.study.answers[case, mesh].first(self.study.count).frequencies,
                                *values], axis=0)  # fmt: skip
        nothing = np.full_like(steps, np.nan)
        return np.asarray(np.divide(steps, values[-1], out=nothing, where=values[-1] != 0))

    @cached_property
    def seen(self) -> dict[Case, dict[Named, list[Verification | None]]]:
        """What the simulators' meshes say by case and simulator, in the theory's order of modes.

        None where a simulator has no three meshes, or one of them failed.
        """
        known = {model: verified(self.study, steps) for model, steps in self.ladders.items()}

        def seen(case: Case, model: Named) -> list[Verification | None]:
            steps = self.ladders.get(model)
            pairing = steps and self.study.pairing(case, self.meshes[-1], steps[-1])
            if not pairing:
                return [None] * self.study.count
            return [known[model].get((case, i + 1)) for i in pairing.partner.tolist()]

        return {case: {m: seen(case, m) for m in self.simulators} for case in self.shares}

    def band(self, case: Case, model: Named) -> Array:
        """Return the GCI of a simulator, (count,) [%]; NaN where it has no three meshes."""
        return np.array([one.band if one else np.nan for one in self.seen[case][model]])

    def records(self) -> Iterator[dict[str, Any]]:
        """Return one row a case, s, mode and part, and the reference's own GCI."""
        for case, shares in self.shares.items():
            for s, table in zip(self.elements, shares, strict=True):
                for i in self.shown:
                    for part, share in zip(self.parts, table, strict=True):
                        yield {
                            "case": case.name, "theory": self.theory.name,
                            "reference": self.reference.label, "elements": s, "mode": i,
                            "part": part, "share_percent": share[i - 1],
                            "reference_gci_percent": self.band(case, self.reference)[i - 1],
                        }  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return the parts, their sum and the reference's own GCI, in percentage points."""
        rows: list[tuple[Cell, ...]] = []
        for case, shares in self.shares.items():
            for s, table in zip(self.elements, shares, strict=True):
                every = (*zip(self.parts, table, strict=True), ("total error", table.sum(axis=0)))
                for part, share in every:
                    rows.append((case.name, s, part, *cells(at(share, self.shown), 3, signed=True)))
            for model in self.simulators:
                known = cells(at(self.band(case, model), self.shown), 3, none="not known")
                whose = "reference's" if model == self.reference else f"{model.label}'s"
                rows.append((case.name, "", f"{whose} own GCI, +-", *known))
        return {"": Table(
            f"Error of {self.theory.name}@s against {self.reference.label}, by cause [points]",
            ("Case", "s", "Part", *(f"f{i}" for i in self.shown)),
            tuple(rows),
            (*self._notes(), *failure_notes(self.study), *case_notes(self.study.cases)),
        )}  # fmt: skip

    def _notes(self) -> Iterator[str]:
        if len(self.simulators) > 1:
            without, name = self.simulators[0].name, self.reference.name
            yield f"{self.reference.info().assumption}: {without} is without, {name} has it"
        for case in self.shares:
            for mesh in self.meshes:
                yield from pairing_notes(self.study, case, mesh, self.reference, self.shown)
            for model, seen in self.seen[case].items():
                said = {i: one.remark for i in self.shown if (one := seen[i - 1])}
                for remark in filter(None, dict.fromkeys(said.values())):
                    modes = ", ".join(f"f{i}" for i, own in said.items() if own == remark)
                    yield f"{case.name}: GCI of {model.label}: {modes} {remark}"
        for model, steps in self.ladders.items():
            numbers = ", ".join(str(mesh.elements) for mesh in steps)
            yield f"GCI of {model.label}: grid convergence index from {numbers} elements"

    def figures(self) -> dict[str, Figure]:
        """Return the parts as stacked bars."""
        return {"": budget_figure(self)} if self.shares else {}

    def sentences(self) -> list[str]:
        """Return the range of each part over cases, with the paper's number of elements."""
        if not self.shares or PAPER_ELEMENTS not in self.elements:
            return []
        k = self.elements.index(PAPER_ELEMENTS)
        # The paper's modes come in two kinds: the platform moves, or the limbs bend.
        halves = [[i for i in self.shown if (i <= 3) == low] for low in (True, False)]
        table = np.array([shares[k] for shares in self.shares.values()])
        known = {
            f"f{half[0]}" if len(half) == 1 else f"f{half[0]}-f{half[-1]}": at(table, half)
            for half in halves if half
        }  # fmt: skip
        parts = "; ".join(
            f"{part} "
            + " and ".join(f"{span(v[:, p], signed=True)} on {on}" for on, v in known.items())
            for p, part in enumerate(self.parts)
        )
        bands = np.array([self.band(case, self.reference) for case in self.shares])
        own = at(bands, self.shown)
        said = "not known" if np.isnan(own).any() else percent(float(own.max()), "at most ")
        ours = self.meshes[k].label
        return [
            f"{ours} against {self.reference.label}, by cause: {parts}. The reference's own GCI: "
            f"{said}."
        ]


def solids(reference: Named) -> tuple[Named, ...]:
    """Return the reference without its assumption where that can run, then the reference."""
    relaxed = reference.info().relaxed
    without = [parse(relaxed, "reference")] if relaxed else []
    return (*(one for one in without if not one.info().missing), reference)


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


def run(request: Request, bench: Bench) -> Budget:
    """Return the budget of the theory against the first reference: parts add up to the error."""
    simulators = solids(request.references[0])
    refined = [mesh for model in simulators for mesh in meshes(model)]
    return Budget.of(request, bench, [*simulators, *exact_chain(request.theory), *refined])


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: against beams that share the theory, and against solids."""
    return {
        "budget" if reference == plan.solid else f"budget-{reference.name}": plan.request(
            references=(reference,), elements=(1, 2, 3, 4)
        )
        for reference in plan.against
    }


def budget_figure(result: Budget) -> Figure:
    """Return stacked bars, one a mode and s, a panel a case; a mark with its value is the total."""
    title = (
        f"Error of {result.theory.name} with s elements a limb against {result.reference.label}, "
        "by cause"
    )
    heads = [case.heading for case in result.shares]
    figure, (row,) = panels(title, 1, len(heads), (6.8, 4.6), heads, sharey=True)
    width, place = 0.84 / len(result.elements), np.arange(len(result.shown))
    for axes, (case, shares) in zip(row, result.shares.items(), strict=True):
        own = at(result.band(case, result.reference), result.shown)
        ticks: list[float] = []
        for k, table in enumerate(np.nan_to_num(at(shares, result.shown))):
            where, total = place + (k - (len(result.elements) - 1) / 2) * width, table.sum(axis=0)
            up, down = np.zeros(len(place)), np.zeros(len(place))
            for p, (part, share) in enumerate(zip(result.parts, table, strict=True)):
                axes.bar(where, share, 0.9 * width, bottom=np.where(share >= 0, up, down),
                         color=COLOURS[p], label=part if k == 0 else None)  # fmt: skip
                up, down = up + np.maximum(share, 0), down + np.minimum(share, 0)
            axes.errorbar(where, total, own, fmt="D", ms=4.5, color="black", mec="white", mew=0.7,
                          elinewidth=0.8, capsize=2, label="total" if k == 0 else None)  # fmt: skip
            for x, top, value in zip(where, np.maximum(up, total), total, strict=True):
                axes.annotate(f"{value:+.2f}", (x, top), xytext=(0, 6), ha="center", rotation=90,
                              textcoords="offset points", fontsize=7)  # fmt: skip
            ticks += where.tolist()
        names = np.repeat(result.elements, len(place))
        axes.set_xticks(ticks, [f"{s}" for s in names], minor=True, fontsize=7)
        axes.set_xticks(place, [f"$f_{{{i}}}$" for i in result.shown])
        axes.tick_params(axis="x", which="major", length=0, pad=13)
        axes.set_xlabel("under each bar: s; whiskers: the reference's own GCI", fontsize=8)
        axes.axhline(0, color="0.4", lw=0.8)
        axes.margins(y=0.2)  # room for the totals' values
    row[0].set_ylabel("share of the error [percentage points]")
    row[0].legend(fontsize=8, loc="upper left")
    return figure
