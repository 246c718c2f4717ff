"""Convergence with the number of elements s: Fig. 3, and the discretisation error alone."""

from collections.abc import Iterator
from functools import cached_property
from itertools import pairwise
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
    pairing_notes,
)
from harness.figures import look, panels, write_ends
from harness.request import Plan, Request
from harness.signatures import Array, Figure
from harness.studies.refinement import MESHES, ROUNDING, Family
from harness.tables import Row, Table

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
        if (limit := self.theory.limit()) is None:
            return np.full(self.study.count, np.nan)
        return np.asarray(errors(self.study, limit, self.reference, [case])[0])

    def order(self, case: Case) -> Array:
        """Return the observed order from each s to the next, shape (len(elements) - 1, count).

        p = log(e_a / e_b) / log(s_b / s_a), meaningful only if the reference is the theory's own
        limit; NaN where an error is rounding.
        """
        size = np.abs(self.errors[case])
        size = np.log(np.where(size < 100 * ROUNDING, np.nan, size))
        return np.asarray(-np.diff(size, axis=0) / np.diff(np.log(self.elements))[:, None])

    def quoted(self, case: Case, s: int) -> list[float]:
        """Return what the paper quotes with Fig. 3 of the modes shown, NaN where nothing."""
        errors = {} if case.paper is None else case.paper.errors
        return [errors.get((case.published, s, i), np.nan) for i in self.shown]

    def records(self) -> Iterator[dict[str, Any]]:
        """Return one row a case, s and mode: the error, and what the paper quotes."""
        for case, found in self.errors.items():
            for s, row in zip(self.elements, at(found, self.shown), strict=True):
                for i, error, quoted in zip(self.shown, row, self.quoted(case, s), strict=True):
                    yield {
                        "case": case.name, "theory": self.theory.name,
                        "reference": self.reference.label, "elements": s, "mode": i,
                        "error_percent": error, "printed_percent": quoted,
                    }  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return the errors and what the last three s say of them.

        Against the theory's own limit also the observed order from each s to the next. Fewer than
        three s say nothing.
        """
        rows, notes = list[Row](), list[str]()
        for case, found in self.errors.items():
            for s, row in zip(self.elements, at(found, self.shown), strict=True):
                rows.append((case.name, s, "", *cells(row, 4, signed=True)))
                quoted = self.quoted(case, s)
                if np.isfinite(quoted).any() and not self.same_theory:
                    rows.append((case.name, s, "printed", *cells(quoted, signed=True, none="")))
            for mesh in self.meshes:
                every = range(1, self.study.count + 1)
                notes += pairing_notes(self.study, case, mesh, self.reference, every)
        notes += failure_notes(self.study) + case_notes(self.study.cases)
        name, against = f"{self.theory.name}@s", self.reference.label
        what = "Discretisation error alone" if self.same_theory else "Fig. 3: error against s"
        columns = ("Case", "s", "", *(f"e{i}" for i in self.shown))
        tables = {"": Table(f"{what}: {name} against {against} [%]", columns, rows, notes)}
        if self.same_theory and len(self.elements) > 1:
            rows = [
                (case.name, f"{a} to {b}", *cells(at(order, self.shown), none="rounding"))
                for case in self.errors
                for (a, b), order in zip(pairwise(self.elements), self.order(case), strict=True)
            ]
            about = "rounding: the error is below 1e-10 of the frequency, no order can be read"
            columns = ("Case", "s", *(f"f{i}" for i in self.shown))
            title = f"Observed order of convergence: {name} to {against}"
            tables["-order"] = Table(title, columns, rows, [about])
        if len(self.elements) >= MESHES:
            last = Family.of(self.study, self.meshes[-MESHES:])
            tables["-verification"] = last.table(self.study, self.shown)
        return tables

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

    own, s = result.same_theory, np.array(result.elements)
    curves = {case: np.abs(off) if own else off for case, off in result.errors.items()}
    title = f"{result.theory.name} with s elements a limb against {result.reference.label}"
    title += "" if own else "; dotted: without elements, the floor"
    heads = [case.heading for case in curves]
    figure, (row,) = panels(title, 1, len(heads), (5.2, 4.4), heads, sharey=True)
    positive = own or all((found > 0).all() for found in curves.values())
    for axes, (case, found) in zip(row, curves.items(), strict=True):
        for i in result.shown:
            # Of two curves that coincide the first is seen round the second, which is open.
            axes.plot(s, found[:, i - 1],
                      **look(i) | ({"mfc": "white"} if i % 2 else {"ls": "--"}))  # fmt: skip
            if not own:
                colour = look(i)["color"]
                axes.axhline(result.floor(case)[i - 1], ls=":", lw=1.4, color=colour, zorder=1)
        for number in () if own else result.elements:
            for i, value in zip(result.shown, result.quoted(case, number), strict=True):
                if np.isfinite(value):
                    axes.plot(number, value, "*", color=look(i)["color"], ms=11, mec="white",
                              mew=0.6)  # fmt: skip
        axes.set_xlabel("number of elements $s$")
        axes.grid(alpha=0.25, which="both")
        if positive:  # f1-f3 would lie on each other at the foot of f4-f6
            axes.set_yscale("log")
        else:
            axes.axhline(0, color="0.4", lw=0.8)
        if own:
            axes.set_xscale("log", base=2)
            axes.set_xticks(s, s.astype(str))
            slope = result.theory.info().order
            line = 2 * np.nanmax(found[0]) * (s / s[0]) ** -slope
            axes.plot(s, line, ls=":", color="0.4", label=f"order {slope:g}")
            continue
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        if positive:
            axes.yaxis.set_major_formatter("{x:g}")
            axes.yaxis.set_minor_formatter(NullFormatter())
    for axes, found in zip(row, curves.values(), strict=True):
        write_ends(axes, {str(look(i)["label"]): found[-1, i - 1] for i in result.shown})
    row[0].set_ylabel(f"{'discretisation' if own else 'relative'} error [%]")
    if not own and any(case.paper and case.paper.errors for case in curves):
        row[-1].plot([], [], "*", color="0.5", ms=11, mec="white", label="quoted in the paper")
    row[-1].legend(fontsize=9, ncols=2)
    return figure
