"""Convergence with the number of elements s: Fig. 3, and the discretisation error alone."""

from collections.abc import Iterator
from functools import cached_property
from typing import Any

import numpy as np

from harness.bench import Bench
from harness.case import Case
from harness.compare import (
    AgainstElements,
    at,
    case_notes,
    cells,
    errors,
    failure_notes,
    match,
    pairing_notes,
)
from harness.figures import look, panels, write_ends
from harness.plan import Plan
from harness.request import Request
from harness.signatures import Array, Figure
from harness.studies.refinement import MESHES, ROUNDING, Family
from harness.tables import Cell, Number, Table

DEFAULTS = {"elements": "1-8"}
EACH_REFERENCE = True
LADDER = (1, 2, 4, 8, 16)
"""Doubling, to read the order of convergence from."""


class Convergence(AgainstElements):
    """Errors of a theory as its elements grow."""

    @cached_property
    def errors(self) -> dict[Case, Array]:
        """The errors by case, (len(elements), count) [%], NaN where a model failed."""
        found = np.array([errors(self.study, mesh, self.reference) for mesh in self.meshes])
        return dict(zip(self.study.cases, found.swapaxes(0, 1), strict=True))

    @property
    def same_theory(self) -> bool:
        """Whether the reference is the theory's own limit, so that errors are discretisation."""
        return self.reference == self.theory.limit()

    def floor(self, case: Case) -> Array:
        """Return the error that no number of elements removes [%], (count,): without any.

        NaN where the theory has no limit, or one of the two failed.
        """
        limit = self.theory.limit()
        found = None if limit is None else match(self.study, case, limit, self.reference)
        return np.full(self.study.count, np.nan) if found is None else found.error

    def order(self, case: Case) -> Array:
        """Return the observed order from each s to the next, shape (len(elements) - 1, count).

        p = log(e_a / e_b) / log(s_b / s_a), meaningful only if the reference is the theory's own
        limit; NaN where an error is rounding.
        """
        size = np.abs(self.errors[case])
        size = np.where(size < 100 * ROUNDING, np.nan, size)
        ratio = np.log(np.array(self.elements[1:]) / np.array(self.elements[:-1]))
        return np.asarray(np.log(size[:-1] / size[1:]) / ratio[:, None])

    def quoted(self, case: Case, s: int) -> list[float | None]:
        """Return what the paper quotes with Fig. 3 of the modes shown."""
        errors = {} if case.paper is None else case.paper.errors
        return [errors.get((case.published, s, i)) for i in self.shown]

    def records(self) -> Iterator[dict[str, Any]]:
        """Return one row a case, s and mode: the error, and what the paper quotes."""
        for case, found in self.errors.items():
            for s, row in zip(self.elements, found, strict=True):
                for i, quoted in zip(self.shown, self.quoted(case, s), strict=True):
                    yield {
                        "case": case.name, "theory": self.theory.name,
                        "reference": self.reference.label, "elements": s, "mode": i,
                        "error_percent": row[i - 1], "printed_percent": quoted,
                    }  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return the errors and what the last three s say of them.

        Against the theory's own limit also the observed order from each s to the next. Fewer than
        three s say nothing.
        """
        tables = {"": self._errors_table()}
        if self.same_theory and len(self.elements) > 1:
            tables["-order"] = self._order_table()
        if len(self.elements) >= MESHES:
            last = Family.of(self.study, self.meshes[-MESHES:])
            tables["-verification"] = last.table(self.study, self.shown)
        return tables

    def _errors_table(self) -> Table:
        rows: list[tuple[Cell, ...]] = []
        for case, found in self.errors.items():
            for s, row in zip(self.elements, found, strict=True):
                rows.append((case.name, s, "", *cells(at(row, self.shown), 4, signed=True)))
                quoted = self.quoted(case, s)
                if any(value is not None for value in quoted) and not self.same_theory:
                    given = ("" if v is None else Number(v, 2, True) for v in quoted)
                    rows.append((case.name, s, "printed", *given))
        what = "Discretisation error alone" if self.same_theory else "Fig. 3: error against s"
        every = range(1, self.study.count + 1)
        notes = [
            note for case in self.errors for mesh in self.meshes
            for note in pairing_notes(self.study, case, mesh, self.reference, every)
        ]  # fmt: skip
        return Table(
            f"{what}: {self.theory.name}@s against {self.reference.label} [%]",
            ("Case", "s", "", *(f"e{i}" for i in self.shown)),
            tuple(rows),
            (*notes, *failure_notes(self.study), *case_notes(self.study.cases)),
        )

    def _order_table(self) -> Table:
        rows = tuple(
            (case.name, f"{self.elements[k]} to {self.elements[k + 1]}",
             *cells(at(row, self.shown), none="rounding"))
            for case in self.errors for k, row in enumerate(self.order(case))
        )  # fmt: skip
        return Table(
            f"Observed order of convergence: {self.theory.name}@s to {self.reference.label}",
            ("Case", "s", *(f"f{i}" for i in self.shown)),
            rows,
            ("rounding: the error is below 1e-10 of the frequency, no order can be read",),
        )

    def figures(self) -> dict[str, Figure]:
        """Return Fig. 3: error against s, one panel a case."""
        return {"": convergence_figure(self)}

    def sentences(self) -> list[str]:
        """Return the observed order of the discretisation error over the two finest meshes."""
        if not self.same_theory or len(self.elements) < 2:
            return []
        last = np.array([self.order(case)[-1] for case in self.errors])
        if not np.isfinite(last).any():
            return []
        coarse, fine = self.elements[-2:]
        return [
            f"From {coarse} to {fine} elements the discretisation error of {self.theory.name} "
            f"falls with order {np.nanmin(last):.2f} to {np.nanmax(last):.2f}; in theory "
            f"{self.theory.info().order:g}."
        ]


def run(request: Request, bench: Bench) -> Convergence:
    """Return the convergence of the theory against the first reference."""
    limit = request.theory.limit()
    return Convergence.of(request, bench, [] if limit is None else [limit])


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: Fig. 3, and the discretisation error alone."""
    found = {"fig3": plan.request(elements=plan.elements)}
    limit = plan.theory.limit()
    if limit is not None:
        found["discretisation"] = plan.request(elements=LADDER, references=(limit,))
    return found


def convergence_figure(result: Convergence) -> Figure:
    """Return Fig. 3: error against s, one panel a case, (a), (b) ...; stars: printed values.

    What each curve ends at is written beside it. Against the theory's own limit the axes are
    logarithmic, and a line shows the formal order.
    """
    from matplotlib.ticker import MaxNLocator, NullFormatter

    cases, own = list(result.errors), result.same_theory
    title = f"{result.theory.name} with s elements a limb against {result.reference.label}"
    title += "" if own else "; dotted: without elements, the floor"
    heads = [case.heading for case in cases]
    figure, (row,) = panels(title, 1, len(cases), (5.2, 4.4), heads, sharey=True)
    positive = own or all((found > 0).all() for found in result.errors.values())
    for axes, case in zip(row, cases, strict=True):
        found = np.abs(result.errors[case]) if own else result.errors[case]
        for i in result.shown:
            # Of two curves that coincide the first is seen round the second, which is open.
            axes.plot(result.elements, found[:, i - 1],
                      **look(i) | ({"mfc": "white"} if i % 2 else {"ls": "--"}))  # fmt: skip
            if not own:
                axes.axhline(
                    result.floor(case)[i - 1], ls=":", lw=1.4, color=look(i)["color"], zorder=1
                )
        for number in () if own else result.elements:
            for i, quoted in zip(result.shown, result.quoted(case, number), strict=True):
                if quoted is not None:
                    axes.plot(
                        number, quoted, "*", color=look(i)["color"], ms=11, mec="white", mew=0.6
                    )
        axes.set_xlabel("number of elements $s$")
        axes.grid(alpha=0.25, which="both")
        if positive:  # f1-f3 would lie on each other at the foot of f4-f6
            axes.set_yscale("log")
        else:
            axes.axhline(0, color="0.4", lw=0.8)
        if own:
            axes.set_xscale("log", base=2)
            axes.set_xticks(result.elements, [f"{s}" for s in result.elements])
            slope, s = result.theory.info().order, np.array(result.elements, dtype=float)
            line = 2 * np.nanmax(found[0]) * (s / s[0]) ** -slope
            axes.plot(s, line, ls=":", color="0.4", label=f"order {slope:g}")
            continue
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        if positive:
            axes.yaxis.set_major_formatter("{x:g}")
            axes.yaxis.set_minor_formatter(NullFormatter())
    for axes, case in zip(row, cases, strict=True):
        last = (np.abs(result.errors[case]) if own else result.errors[case])[-1]
        write_ends(axes, {str(look(i)["label"]): last[i - 1] for i in result.shown})
    row[0].set_ylabel(f"{'discretisation' if own else 'relative'} error [%]")
    if not own and any(case.paper and case.paper.errors for case in cases):
        row[-1].plot([], [], "*", color="0.5", ms=11, mec="white", label="quoted in the paper")
    row[-1].legend(fontsize=9, ncols=2)
    return figure
