"""The error, split into its causes: parts that add up to the paper's one "error (%)"."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
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
from harness.presets import PAPER_ELEMENTS
from harness.request import Plan, Request
from harness.signatures import Array, Axes, Figure
from harness.studies.refinement import Ladder, Verification, ladder, verified
from harness.tables import Row, Table
from reference_models import Named, parse

DEFAULTS = {"elements": "1-4"}
ELEMENTS = "number of elements"
"""The first part: what vanishes as s grows."""


@dataclass(frozen=True)
class Budget(AgainstElements):
    """The error of a theory, in `parts`.

    A part is 100 (f_a - f_b) / f_reference between neighbours of a chain: theory with s elements,
    then `chain`: theory without, each richer beam theory without, the reference without its
    assumption, reference. Every mode is followed by its shape. `ladders`: the simulators of the
    chain, each with its three meshes, if it has them.
    """

    parts: tuple[str, ...]
    chain: tuple[Named, ...]
    ladders: Mapping[Named, Ladder]

    @cached_property
    def shares(self) -> dict[Case, Array]:
        """Parts by case, (len(elements), parts, count) [points of the reference's frequency].

        Their sum over the parts is the error; NaN against 0 Hz. Of cases without a failure.
        """
        shares = {}
        for case in self.study.complete(*self.chain, *self.meshes):
            f = np.array([
                [one.against for model in (mesh, *self.chain)
                 if (one := match(self.study, case, mesh, model))]
                for mesh in self.meshes
            ])  # fmt: skip
            steps, whole = -100 * np.diff(f, axis=1), f[:, -1:]
            nothing = np.full_like(steps, np.nan)
            shares[case] = np.asarray(np.divide(steps, whole, out=nothing, where=whole != 0))
        return shares

    @cached_property
    def seen(self) -> dict[tuple[Case, Named], list[Verification | None]]:
        """What a simulator's meshes say at a case, in the theory's order of modes, if anything."""
        seen = {}
        for model, steps in self.ladders.items():
            known = verified(self.study, steps) if steps else {}
            for case in self.shares:
                pairing = steps and self.study.pairing(case, self.meshes[-1], steps[-1])
                places = pairing.partner.tolist() if pairing else range(self.study.count)
                seen[case, model] = [known.get((case, i + 1)) for i in places]
        return seen

    def band(self, case: Case, model: Named) -> Array:
        """Return the GCI of a simulator, (count,) [%]; NaN where it has no three meshes."""
        return np.array([one.band if one else np.nan for one in self.seen[case, model]])

    def records(self) -> Iterator[dict[str, Any]]:
        """Return one row a case, s, mode and part, and the reference's own GCI."""
        for case, shares in self.shares.items():
            band = self.band(case, self.reference)
            for s, table in zip(self.elements, shares, strict=True):
                for i in self.shown:
                    for part, share in zip(self.parts, table[:, i - 1], strict=True):
                        yield {
                            "case": case.name, "theory": self.theory.name,
                            "reference": self.reference.label, "elements": s, "mode": i,
                            "part": part, "share_percent": share,
                            "reference_gci_percent": band[i - 1],
                        }  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return the parts, their sum and the reference's own GCI, in percentage points."""
        rows: list[Row] = []
        for case, shares in self.shares.items():
            for s, table in zip(self.elements, at(shares, self.shown), strict=True):
                rows += [(case.name, s, part, *cells(share, 3, signed=True))
                         for part, share in zip(self.parts, table, strict=True)]  # fmt: skip
                total = cells(table.sum(axis=0), 3, signed=True)
                rows.append((case.name, s, "total error", *total))
            for model in self.ladders:
                known = cells(at(self.band(case, model), self.shown), 3, none="not known")
                whose = "reference's" if model == self.reference else f"{model.label}'s"
                rows.append((case.name, "", f"{whose} own GCI, +-", *known))
        title = f"Error of {self.theory.name}@s against {self.reference.label}, by cause [points]"
        columns = ("Case", "s", "Part", *(f"f{i}" for i in self.shown))
        notes = *self._notes(), *failure_notes(self.study), *case_notes(self.study.cases)
        return {"": Table(title, columns, rows, notes)}

    def _notes(self) -> Iterator[str]:
        without, *others = self.ladders
        if others:
            name = self.reference.name
            yield f"{self.reference.info().assumption}: {without.name} is without, {name} has it"
        for case in self.shares:
            for mesh in self.meshes:
                yield from pairing_notes(self.study, case, mesh, self.reference, self.shown)
            for model in self.ladders:
                modes: dict[str, list[str]] = {}
                for i in self.shown:
                    if (one := self.seen[case, model][i - 1]) and one.remark:
                        modes.setdefault(one.remark, []).append(f"f{i}")
                for remark, own in modes.items():
                    yield f"{case.name}: GCI of {model.label}: {', '.join(own)} {remark}"
        for model, steps in self.ladders.items():
            if steps:
                numbers = ", ".join(str(mesh.elements) for mesh in steps)
                yield f"GCI of {model.label}: grid convergence index from {numbers} elements"

    def sentences(self) -> list[str]:
        """Return the range of each part over cases, with the paper's number of elements."""
        if not self.shares or PAPER_ELEMENTS not in self.elements:
            return []
        k = self.elements.index(PAPER_ELEMENTS)
        # The paper's modes come in two kinds: the platform moves, or the limbs bend.
        halves = [[i for i in self.shown if (i <= 3) == low] for low in (True, False)]
        table = np.array([shares[k] for shares in self.shares.values()])
        known = {f"f{half[0]}" + (f"-f{half[-1]}" if half[1:] else ""): at(table, half)
                 for half in halves if half}  # fmt: skip
        parts = "; ".join(
            f"{part} " + " and ".join(f"{span(v[:, p])} on {on}" for on, v in known.items())
            for p, part in enumerate(self.parts)
        )
        own = at(np.array([self.band(case, self.reference) for case in self.shares]), self.shown)
        said = "not known" if np.isnan(own).any() else percent(float(own.max()), "at most ")
        return [
            f"{self.meshes[k].label} against {self.reference.label}, by cause: {parts}. The "
            f"reference's own GCI: {said}."
        ]

    def figures(self) -> dict[str, Figure]:
        """Return stacked bars, one a mode and s, a panel a case; a mark with its value is the
        total."""
        if not self.shares:
            return {}
        title = (
            f"Error of {self.theory.name} with s elements a limb against {self.reference.label}, "
            "by cause"
        )
        heads = [case.heading for case in self.shares]
        figure, (row,) = panels(title, 1, len(heads), (6.8, 4.6), heads, sharey=True)
        for axes, (case, shares) in zip(row, self.shares.items(), strict=True):
            own = at(self.band(case, self.reference), self.shown)
            self._bars(axes, np.nan_to_num(at(shares, self.shown)), own)
        row[0].set_ylabel("share of the error [percentage points]")
        row[0].legend(fontsize=8, loc="upper left")
        return {"": figure}

    def _bars(self, axes: Axes, shares: Array, own: Array) -> None:
        """Draw a panel: `shares` (len(elements), parts, modes), `own` bands of the reference."""
        width, place = 0.84 / len(self.elements), np.arange(len(self.shown))
        middle = (len(self.elements) - 1) / 2
        ticks = np.array([place + (k - middle) * width for k in range(len(self.elements))])
        for k, (where, table) in enumerate(zip(ticks, shares, strict=True)):
            total, up, down = table.sum(axis=0), np.zeros(len(place)), np.zeros(len(place))
            for p, (part, share) in enumerate(zip(self.parts, table, strict=True)):
                axes.bar(where, share, 0.9 * width, bottom=np.where(share >= 0, up, down),
                         color=COLOURS[p], label=part if k == 0 else None)  # fmt: skip
                up, down = up + np.maximum(share, 0), down + np.minimum(share, 0)
            axes.errorbar(where, total, own, fmt="D", ms=4.5, color="black", mec="white", mew=0.7,
                          elinewidth=0.8, capsize=2, label="total" if k == 0 else None)  # fmt: skip
            for x, top, value in zip(where, np.maximum(up, total), total, strict=True):
                axes.annotate(f"{value:+.2f}", (x, top), xytext=(0, 6), ha="center", rotation=90,
                              textcoords="offset points", fontsize=7)  # fmt: skip
        names = np.repeat(self.elements, len(place)).astype(str)
        axes.set_xticks(ticks.ravel(), names, minor=True, fontsize=7)
        axes.set_xticks(place, [f"$f_{{{i}}}$" for i in self.shown])
        axes.tick_params(axis="x", which="major", length=0, pad=13)
        axes.set_xlabel("under each bar: s; whiskers: the reference's own GCI", fontsize=8)
        axes.axhline(0, color="0.4", lw=0.8)
        axes.margins(y=0.2)  # room for the totals' values


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
    reference, exact = request.references[0], exact_chain(request.theory)
    ladders = {model: meshes(model) for model in solids(reference)}
    last = ["three-dimensional effects", reference.info().assumption]
    if len(ladders) == 1:
        last = [f"{BEAMS[exact[-1].name] if exact else 'theory'} to reference"]
    refined = [mesh for steps in ladders.values() for mesh in steps]
    parts = (*((ELEMENTS,) if exact else ()), *effects(exact), *last)
    more = {"parts": parts, "chain": (*exact, *ladders), "ladders": ladders}
    return Budget.of(request, bench, [*ladders, *exact, *refined], **more)


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: against beams that share the theory, and against solids."""
    return {
        "budget" if reference == plan.solid else f"budget-{reference.name}": plan.request(
            references=(reference,), elements=(1, 2, 3, 4)
        )
        for reference in plan.against
    }
