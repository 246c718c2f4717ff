"""Convergence with the number of elements s: Fig. 3, and the discretisation error alone."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from harness import published
from harness.bench import Bench, Study
from harness.cases import Case
from harness.compare import case_notes, cell, failure_notes, pairing_notes, relative_error
from harness.figures import COLOURS, MARKERS
from harness.plan import Plan
from harness.request import Request
from harness.result import Result
from harness.studies.refinement import MESHES, ROUNDING, verification_table
from harness.tables import Cell, Number, Table
from reference_models import Named

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DEFAULTS = {"elements": "1-8"}
EACH_REFERENCE = True
LADDER = (1, 2, 4, 8, 16)
"""Doubling, to read the order of convergence from."""


@dataclass(frozen=True)
class Convergence(Result):
    """Errors of one theory against one reference as s grows.

    Attributes: `study` behind the numbers; `theory`; `reference`; `elements` s;
    `errors` by case, shape (len(elements), count) [%], NaN where a model failed; `shown` mode
    numbers; `notes`.
    """

    study: Study
    theory: Named
    reference: Named
    elements: tuple[int, ...]
    errors: dict[Case, NDArray[np.float64]]
    shown: tuple[int, ...]
    notes: tuple[str, ...]

    @property
    def studies(self) -> tuple[Study, ...]:
        """What was solved for it."""
        return (self.study,)

    @property
    def same_theory(self) -> bool:
        """Whether the reference is the theory's own limit, so that errors are discretisation."""
        return self.reference == self.theory.limit()

    def order(self, case: Case) -> NDArray[np.float64]:
        """Return the observed order from each s to the next, shape (len(elements) - 1, count).

        p = log(e_a / e_b) / log(s_b / s_a), meaningful only if the reference is the theory's own
        limit; NaN where an error is rounding.
        """
        errors = np.abs(self.errors[case])
        errors = np.where(errors < 100 * ROUNDING, np.nan, errors)
        ratio = np.log(np.array(self.elements[1:]) / np.array(self.elements[:-1]))
        return np.asarray(np.log(errors[:-1] / errors[1:]) / ratio[:, None])

    def to_frame(self) -> "pd.DataFrame":
        """Return one row a case, s and mode: the error, and what the paper quotes."""
        import pandas as pd

        return pd.DataFrame([
            {
                "case": case.name,
                "theory": self.theory.name,
                "reference": self.reference.label,
                "elements": s,
                "mode": i,
                "error_percent": errors[k, i - 1],
                "printed_percent": published.figure3().get((case.published, s, i)),
            }
            for case, errors in self.errors.items()
            for k, s in enumerate(self.elements)
            for i in self.shown
        ])  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return the errors and what the last three s say of them.

        Against the theory's own limit also the observed order from each s to the next. Fewer than
        three s say nothing.
        """
        tables = {"": self._errors_table()}
        if self.same_theory and len(self.elements) > 1:
            tables["-order"] = self._order_table()
        if len(self.elements) >= MESHES:
            ladder = tuple(replace(self.theory, elements=s) for s in self.elements[-MESHES:])
            tables["-verification"] = verification_table(self.study, ladder, self.shown)
        return tables

    def figures(self) -> dict[str, "Figure"]:
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

    def _errors_table(self) -> Table:
        rows: list[tuple[Cell, ...]] = []
        for case, errors in self.errors.items():
            for k, s in enumerate(self.elements):
                found = [cell(errors[k][i - 1], 4, signed=True) for i in self.shown]
                rows.append((case.name, s, "", *found))
                quoted = [published.figure3().get((case.published, s, i)) for i in self.shown]
                if any(value is not None for value in quoted) and not self.same_theory:
                    given = ["" if v is None else Number(v, 2, True) for v in quoted]
                    rows.append((case.name, s, "printed", *given))
        what = "Discretisation error alone" if self.same_theory else "Fig. 3: error against s"
        title = f"{what}: {self.theory.name}@s against {self.reference.label} [%]"
        columns = ("Case", "s", "", *(f"e{i}" for i in self.shown))
        notes = (*self.notes, *case_notes(self.study.cases))
        return Table(title, columns, tuple(rows), notes)

    def _order_table(self) -> Table:
        rows: list[tuple[Cell, ...]] = []
        for case in self.errors:
            orders = self.order(case)
            for k, pair in enumerate(zip(self.elements[:-1], self.elements[1:], strict=True)):
                values = [float(orders[k, i - 1]) for i in self.shown]
                found = [Number(p, 2) if np.isfinite(p) else "rounding" for p in values]
                rows.append((case.name, f"{pair[0]} to {pair[1]}", *found))
        title = f"Observed order of convergence: {self.theory.name}@s to {self.reference.label}"
        notes = ("rounding: the error is below 1e-10 of the frequency, no order can be read",)
        return Table(title, ("Case", "s", *(f"f{i}" for i in self.shown)), tuple(rows), notes)


def converge(
    cases: Sequence[Case],
    theory: Named,
    elements: Sequence[int],
    reference: Named,
    shown: Sequence[int],
    bench: Bench,
) -> Convergence:
    """Return the error of `theory` with each number of `elements` against `reference`."""
    count = max(shown)
    meshes = [replace(theory, elements=s) for s in elements]
    study = bench.run(cases, [reference, *meshes], count)
    errors, notes = {}, []
    for case in study.cases:
        table = np.full((len(meshes), count), np.nan)
        for k, mesh in enumerate(meshes):
            ours, against = study.get(case, mesh), study.get(case, reference)
            pairing = study.pairing(case, mesh, reference)
            if ours is None or against is None or pairing is None:
                continue
            fea = against.frequencies[pairing.partner]
            table[k] = relative_error(ours.frequencies[:count], fea)
            notes += pairing_notes(case, mesh, reference, pairing, range(count))
        errors[case] = table
    notes += failure_notes(study)
    return Convergence(
        study, theory, reference, tuple(elements), errors, tuple(shown), tuple(notes)
    )


def run(request: Request, bench: Bench) -> Convergence:
    """Return the convergence of the theory against the first reference."""
    reference = request.references[0]
    return converge(request.cases, request.theory, request.steps, reference, request.shown, bench)


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: Fig. 3, and the discretisation error alone."""
    found = {"fig3": plan.request(elements=plan.elements)}
    limit = plan.theory.limit()
    if limit is not None:
        found["discretisation"] = plan.request(elements=LADDER, references=(limit,))
    return found


def convergence_figure(result: Convergence) -> "Figure":
    """Return Fig. 3: error against s, one panel a case, (a), (b) ...; stars: printed values.

    Against the theory's own limit the axes are logarithmic, and a line shows the formal order.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator, NullFormatter

    cases = list(result.errors)
    figure = Figure(figsize=(5.2 * len(cases), 4.4), layout="constrained")
    panels = figure.subplots(1, len(cases), squeeze=False, sharey=True)[0]
    positive = all((errors > 0).all() for errors in result.errors.values())
    for letter, (axes, case) in enumerate(zip(panels, cases, strict=True)):
        errors = result.errors[case]
        for i in result.shown:
            style: dict[str, Any] = {"color": COLOURS[(i - 1) % 6], "marker": MARKERS[(i - 1) % 6]}
            values = np.abs(errors[:, i - 1]) if result.same_theory else errors[:, i - 1]
            # Of two curves that coincide the first is seen round the second, which is open.
            even = i % 2 == 0
            look = {"markersize": 5, "ls": "--"} if even else {"markersize": 9, "mfc": "white"}
            axes.plot(result.elements, values, **style, **look, lw=1.2, label=f"$e_{i}$")
            for s in () if result.same_theory else result.elements:
                quoted = published.figure3().get((case.published, s, i))
                if quoted is not None:
                    axes.plot(s, quoted, "*", color=style["color"], ms=11, mec="white", mew=0.6)
        axes.set_xlabel("number of elements $s$")
        axes.set_title(f"({chr(97 + letter)}) {case.heading}", fontsize=11)
        axes.grid(alpha=0.25, which="both")
        if result.same_theory:
            _logarithmic(axes, result, errors)
            continue
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        if positive:  # f1-f3 would lie on each other at the foot of f4-f6
            axes.set_yscale("log")
            axes.yaxis.set_major_formatter("{x:g}")
            axes.yaxis.set_minor_formatter(NullFormatter())
        else:
            axes.axhline(0, color="0.4", lw=0.8)
    what = "discretisation error" if result.same_theory else "relative error"
    panels[0].set_ylabel(f"{what} [%]")
    if not result.same_theory and any(case.published for case in cases):
        panels[-1].plot([], [], "*", color="0.3", ms=11, mec="white", label="quoted in the paper")
    panels[-1].legend(fontsize=9, ncols=2)
    figure.suptitle(f"{result.theory.name}@s against {result.reference.label}", fontsize=10)
    return figure


def _logarithmic(axes: "Axes", result: Convergence, errors: NDArray[np.float64]) -> None:
    from matplotlib.ticker import NullFormatter, ScalarFormatter

    s = np.array(result.elements, dtype=float)
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xticks(s)
    slope = result.theory.info().order
    top = np.nanmax(np.abs(errors[0]))
    line = 2 * top * (s / s[0]) ** -slope
    axes.plot(s, line, ls=":", color="0.4", label=f"order {slope:g}")
