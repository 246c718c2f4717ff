"""Convergence with the number of elements s: Fig. 3, and the discretisation error alone."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullFormatter, ScalarFormatter
from numpy.typing import NDArray

from harness import published
from harness.cases import Case
from harness.compare import case_notes, failure_notes, pairing_notes, relative_error
from harness.figures import COLOURS, MARKERS, figure_files
from harness.models import Spec
from harness.refinement import MESHES, ROUNDING, verification_table
from harness.run import Study, run
from harness.tables import Cell, Number, Table


@dataclass(frozen=True)
class Convergence:
    """Errors of one theory against one reference as s grows.

    Attributes: `study` behind the numbers; `theory`; `reference`; `elements` s;
    `errors` by case name, shape (len(elements), count) [%], NaN where the model failed; `notes`.
    """

    study: Study
    theory: Spec
    reference: Spec
    elements: tuple[int, ...]
    errors: dict[str, NDArray[np.float64]]
    notes: tuple[str, ...]

    def order(self, case: str) -> NDArray[np.float64]:
        """Return the observed order from each s to the next, shape (len(elements) - 1, count).

        p = log(e_a / e_b) / log(s_b / s_a), meaningful only if the reference is the theory's own
        limit; NaN where an error is rounding.
        """
        errors = np.abs(self.errors[case])
        errors = np.where(errors < 100 * ROUNDING, np.nan, errors)
        ratio = np.log(np.array(self.elements[1:]) / np.array(self.elements[:-1]))
        return np.asarray(np.log(errors[:-1] / errors[1:]) / ratio[:, None])

    @property
    def same_theory(self) -> bool:
        """Whether the reference is the theory's own limit, so that errors are discretisation."""
        return self.reference == replace(self.theory, elements=None)


def converge(
    cases: Sequence[Case],
    theory: Spec,
    elements: Sequence[int],
    reference: Spec,
    count: int,
    done: Callable[[str], None] = lambda _: None,
) -> Convergence:
    """Return the error of `theory` with each number of `elements` against `reference`."""
    specs = [replace(theory, elements=s) for s in elements]
    study = run(cases, [reference, *specs], count, done)
    errors, notes = {}, []
    for case in cases:
        table = np.full((len(specs), count), np.nan)
        for k, spec in enumerate(specs):
            ours, against = study.get(case, spec), study.get(case, reference)
            pairing = study.pairing(case, spec, reference)
            if ours is None or against is None or pairing is None:
                continue
            fea = against.frequencies[pairing.partner]
            table[k] = relative_error(ours.frequencies[:count], fea)
            notes += pairing_notes(case, spec, reference, pairing, range(count))
        errors[case.name] = table
    notes += failure_notes(study)
    return Convergence(study, theory, reference, tuple(elements), errors, tuple(notes))


def convergence_tables(result: Convergence, shown: Sequence[int]) -> list[Table]:
    """Return the tables of `named_tables`."""
    return list(named_tables(result, shown).values())


def named_tables(result: Convergence, shown: Sequence[int]) -> dict[str, Table]:
    """Return, by the ending of their files, the errors and what the last three s say of them.

    Against the theory's own limit also the observed order from each s to the next. Fewer than
    three s say nothing.
    """
    tables = {"": convergence_table(result, shown)}
    if result.same_theory:
        tables["-order"] = order_table(result, shown)
    if len(result.elements) >= MESHES:
        ladder = [replace(result.theory, elements=s) for s in result.elements[-MESHES:]]
        tables["-verification"] = verification_table(result.study, ladder, shown)
    return tables


def convergence_files(result: Convergence, shown: Sequence[int], stem: str) -> dict[str, bytes]:
    """Return one study's tables and figure as files called `stem`."""
    files = figure_files(convergence_figure(result, shown), stem)
    for ending, table in named_tables(result, shown).items():
        files |= table.files(f"{stem}{ending}")
    return files


def convergence_table(result: Convergence, shown: Sequence[int]) -> Table:
    """Return Fig. 3 as numbers: error [%] against s; the printed errors where there are any."""
    rows: list[tuple[Cell, ...]] = []
    for case in result.study.cases:
        for k, s in enumerate(result.elements):
            errors = result.errors[case.name][k]
            rows.append((case.name, s, "", *(Number(float(errors[i - 1]), 4, True) for i in shown)))
            quoted = [published.figure3().get((case.published, s, i)) for i in shown]
            if any(value is not None for value in quoted) and not result.same_theory:
                cells = ["" if value is None else Number(value, 2, True) for value in quoted]
                rows.append((case.name, s, "printed", *cells))
    notes = (*result.notes, *case_notes(result.study.cases))
    what = "Discretisation error alone" if result.same_theory else "Fig. 3: error against s"
    title = f"{what}: {result.theory.name}@s against {result.reference.label} [%]"
    return Table(title, ("Case", "s", "", *(f"e{i}" for i in shown)), tuple(rows), notes)


def order_table(result: Convergence, shown: Sequence[int]) -> Table:
    """Return the observed order of convergence from each s to the next, for every mode."""
    rows: list[tuple[Cell, ...]] = []
    for case in result.study.cases:
        orders = result.order(case.name)
        for k, pair in enumerate(zip(result.elements[:-1], result.elements[1:], strict=True)):
            cells = [_order(float(orders[k, i - 1])) for i in shown]
            rows.append((case.name, f"{pair[0]} to {pair[1]}", *cells))
    title = f"Observed order of convergence: {result.theory.name}@s to {result.reference.label}"
    notes = ("rounding: the error is below 1e-10 of the frequency, no order can be read",)
    return Table(title, ("Case", "s", *(f"f{i}" for i in shown)), tuple(rows), notes)


def _order(value: float) -> Cell:
    return Number(value, 2) if np.isfinite(value) else "rounding"


def convergence_figure(result: Convergence, shown: Sequence[int]) -> Figure:
    """Return Fig. 3: error against s, one panel a case, (a), (b) ...; hollow: printed values.

    Against the theory's own limit the axes are logarithmic, and a line shows fourth order.
    """
    cases = result.study.cases
    figure = Figure(figsize=(5.2 * len(cases), 4.2), layout="constrained")
    panels = figure.subplots(1, len(cases), squeeze=False, sharey=result.same_theory)[0]
    for letter, (axes, case) in enumerate(zip(panels, cases, strict=True)):
        errors = result.errors[case.name]
        for i in shown:
            style = {"color": COLOURS[(i - 1) % 6], "marker": MARKERS[(i - 1) % 6]}
            values = np.abs(errors[:, i - 1]) if result.same_theory else errors[:, i - 1]
            size = 9 - 4 * ((i - 1) % 2)
            axes.plot(result.elements, values, **style, markersize=size, lw=1.2, label=f"$e_{i}$")
            if result.same_theory:
                continue
            for s in result.elements:
                quoted = published.figure3().get((case.published, s, i))
                if quoted is not None:
                    axes.plot(s, quoted, **style, markersize=11, mfc="none", ls="none", alpha=0.6)
        axes.set_xlabel("number of elements $s$")
        axes.set_title(f"({chr(97 + letter)}) {case.name}", fontsize=11)
        axes.grid(alpha=0.25)
        if result.same_theory:
            _logarithmic(axes, result, errors)
        else:
            axes.axhline(0, color="0.4", lw=0.8)
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    what = "discretisation error" if result.same_theory else "relative error"
    panels[0].set_ylabel(f"{what} [%]")
    panels[-1].legend(fontsize=9)
    hollow = "" if result.same_theory else "; hollow: values printed in the paper"
    figure.suptitle(f"{result.theory.name}@s against {result.reference.label}{hollow}", fontsize=10)
    return figure


def _logarithmic(axes: Axes, result: Convergence, errors: np.ndarray) -> None:
    s = np.array(result.elements, dtype=float)
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xticks(s)
    slope = 4 if result.theory.name == "euler-bernoulli" else 2
    top = np.nanmax(np.abs(errors[0]))
    axes.plot(s, 2 * top * (s / s[0]) ** -slope, ls=":", color="0.4", label=f"order {slope}")
