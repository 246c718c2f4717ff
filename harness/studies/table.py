"""Table I: every reference beside the theory, and both beside what the paper prints."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from analytic.model import Model
from harness import published
from harness.bench import Bench, Study, label
from harness.cases import PRESETS, Case
from harness.causes import effects, exact_chain
from harness.compare import (
    PERCENT,
    at_most,
    case_notes,
    cells,
    failure_notes,
    kind,
    pairing_notes,
    percent,
    relative_error,
    span,
)
from harness.plan import Plan
from harness.printed import against_paper, printed_table
from harness.request import Request
from harness.result import Result
from harness.tables import Cell, Number, Table

if TYPE_CHECKING:
    import pandas as pd

STEM = "table1"
DEFAULTS = {"references": "usual"}
AGREES = 0.1
"""Two sets of figures agree if none differs by more than this [%]: ten times Table I's rounding."""


@dataclass(frozen=True)
class TableOne(Result):
    """Frequencies of `theories` and `references` at the cases of `study`.

    `shown`: mode numbers from 1; `readings`: other readings of the paper, each case by its own
    theory, where asked for.
    """

    study: Study
    theories: tuple[Model, ...]
    references: tuple[Model, ...]
    shown: tuple[int, ...]
    readings: tuple[Study, ...] = ()

    @property
    def studies(self) -> tuple[Study, ...]:
        """What was solved for it."""
        return (self.study, *self.readings)

    def to_frame(self) -> "pd.DataFrame":
        """Return one row a case, model and mode: `Study.to_frame` of the table itself."""
        return self.study.to_frame()

    def tables(self) -> dict[str, Table]:
        """Return Table I, every reference beside it, the readings, and where numbers come from."""
        found = {"": self._table_one()}
        for theory in self.theories:
            ending = f"-{label(theory)}" if len(self.theories) > 1 else ""
            found[f"-references{ending}"] = self._references(theory)
        if any(case.printed for case in self.study.cases):
            found["-printed"] = printed_table(self.study, self.theories)
        if self.readings:
            found["-readings"] = readings_table(self.readings)
            found["-errata"] = errata_table()
        found["-seen"] = seen_table(self.references)
        return found | {"-provenance": provenance_table(self.study)}

    def _table_one(self) -> Table:
        """Return FEA, Theoretical and Error (%) of each pair, then what the paper prints.

        Modes are paired by shape; columns follow the theory's order.
        """
        rows: list[tuple[Cell, ...]] = []
        notes: list[str] = []
        pick = [i - 1 for i in self.shown]
        for case in self.study.cases:
            for theory in self.theories:
                ours = self.study.get(case, theory)
                if ours is None:
                    continue
                for reference in self.references:
                    found = self._pair(case, theory, reference, pick)
                    rows += found[0]
                    notes += found[1]
                rows += _printed(case, theory, ours.frequencies, pick)
        notes += [
            f"{label(model)}: {model.info().remark}" for model in self.references
            if model.info().remark
        ]  # fmt: skip
        notes += case_notes(self.study.cases) + failure_notes(self.study)
        columns = ("Case", "Method", *(f"f{i} [Hz]" for i in self.shown))
        title = "Table I: natural frequencies"
        return Table(title, columns, tuple(rows), tuple(dict.fromkeys(notes)))

    def _pair(
        self, case: Case, theory: Model, reference: Model, pick: list[int]
    ) -> tuple[list[tuple[Cell, ...]], list[str]]:
        ours, against = self.study.get(case, theory), self.study.get(case, reference)
        pairing = self.study.pairing(case, theory, reference)
        if ours is None or against is None or pairing is None:
            return [], []
        fea, what = against.frequencies[pairing.partner], kind(reference)
        error = relative_error(ours.frequencies[: self.study.count], fea)
        rows: list[tuple[Cell, ...]] = [
            (case.name, f"{what} ({label(reference)})", *cells(fea[pick], 3)),
            (case.name, f"Theoretical ({label(theory)})", *cells(ours.frequencies[pick], 3)),
            (case.name, "Error (%)", *cells(error[pick], signed=True)),
        ]
        if against.uncertainty is not None:
            own = relative_error(fea + against.uncertainty[pairing.partner], fea)
            rows.append((case.name, f"{what}'s own uncertainty (%)", *cells(own[pick], 4)))
        return rows, pairing_notes(case, theory, reference, pairing, pick)

    def _references(self, theory: Model) -> Table:
        """Return one column a reference: its frequency, and the error of `theory` against it."""
        rows: list[tuple[Cell, ...]] = []
        for case in self.study.cases:
            ours = self.study.get(case, theory)
            if ours is None:
                continue
            for i in self.shown:
                row: list[Cell] = [case.name, f"f{i}", Number(float(ours.frequencies[i - 1]))]
                for reference in self.references:
                    against = self.study.get(case, reference)
                    pairing = self.study.pairing(case, theory, reference)
                    if against is None or pairing is None:
                        row.append("failed")
                        continue
                    fea = float(against.frequencies[pairing.partner[i - 1]])
                    error = relative_error(ours.frequencies[i - 1], np.array(fea))
                    said = f"{error:+.3f} %" if np.isfinite(error) else "-"
                    mark = " *" if pairing.reordered[i - 1] or pairing.doubtful[i - 1] else ""
                    row.append(f"{fea:.3f} ({said}){mark}")
                rows.append(tuple(row))
        notes = [
            "in brackets: error of the theoretical value; *: paired by shape against the order"
        ]
        columns = ("Case", "Mode", label(theory), *map(label, self.references))
        title = "Every reference beside the theory [Hz]"
        return Table(title, columns, tuple(rows), tuple(notes + failure_notes(self.study)))

    def sentences(self) -> list[str]:
        """Return what agrees with the printed table, what elements and theory cost, and why."""
        theory = self.theories[0]
        cases = self.study.complete(theory)
        printed = [case for case in cases if case.published]
        lines = against_print(self.study, theory, printed) if printed else []
        lines += against_paper(self.study, theory)
        lines += causes(self.study, theory)
        lines += [line for model in self.references for line in _against_limit(self.study, model)]
        return lines + closest_readings(self.readings)


def table_one(
    cases: Sequence[Case],
    theories: Sequence[Model],
    references: Sequence[Model],
    shown: Sequence[int],
    bench: Bench,
) -> TableOne:
    """Return Table I of `theories` against `references` with the exact limits of both."""
    some = [*theories, *references]
    limits = [limit for model in some if (limit := model.limit()) is not None]
    study = bench.run(cases, [*some, *limits, *exact_chain(theories[0])[-1:]], max(shown))
    return TableOne(study, tuple(theories), tuple(references), tuple(shown))


def run(request: Request, bench: Bench) -> TableOne:
    """Return Table I; with `elements`, one theory for each of them."""
    theories = [request.theory]
    if request.elements is not None:
        theories = [replace(request.theory, elements=s) for s in request.elements]
    found = table_one(request.cases, theories, request.references, request.shown, bench)
    if not request.options.get("readings"):
        return found
    readings = [bench.run([case], [case.theory], 6) for case in PRESETS.values()]
    return replace(found, readings=tuple(readings))


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: also every reading of the paper, if its cases are asked."""
    paper = any(case.published for case in plan.cases)
    return {"table1": plan.request(options={"readings": paper})}


def readings_table(readings: Sequence[Study]) -> Table:
    """Return each case's own model against the printed Table I [%]: no reading gives all of it."""
    rows: list[tuple[Cell, ...]] = []
    for study in readings:
        for (case, model), modes in study.answers.items():
            printed = np.array(published.table1()[case.published, "Theoretical"])
            error = relative_error(modes.frequencies[:6], printed)
            rows.append((case.name, label(model), *cells(error, signed=True), case.note))
    columns = ("Case", "Model", *(f"f{i} [%]" for i in range(1, 7)), "What was read or fitted")
    title = "Readings of the paper: theoretical values against the printed Table I"
    return Table(title, columns, tuple(rows))


def provenance_table(study: Study) -> Table:
    """Return where every number comes from: theory, version, coordinates and joint gap a case."""
    rows: list[tuple[Cell, ...]] = []
    for (case, model), modes in study.answers.items():
        closed = "none can open" if modes.residual is None else f"{modes.residual:.0e}"
        rows.append((case.name, label(model), modes.theory, modes.version, modes.dofs, closed))
    columns = ("Case", "Model", "Theory", "Version", "dofs", "joint gap [m]")
    return Table("Where the numbers come from", columns, tuple(rows))


def seen_table(references: Sequence[Model]) -> Table:
    """Return what each reference can see, and what it cannot."""
    rows: list[tuple[Cell, ...]] = []
    for model in references:
        info = model.info()
        warps = "sections that warp" if info.limit else ""
        blind = [
            *effects(exact_chain(model)),
            warps,
            "" if info.torsion else "limbs that twist alone",
            info.assumption,
        ]
        exact = "" if info.limit else "has no exact limit to be checked by"
        rows.append((label(model), info.theory, f"{info.program} {info.version}".strip(),
                     "; ".join(filter(None, blind)) or "-",
                     "; ".join(filter(None, [exact, info.remark])) or "-"))  # fmt: skip
    columns = ("Reference", "What it sees of a rod", "Program", "What it does not see", "Remark")
    return Table("What each reference can see", columns, tuple(rows))


def errata_table() -> Table:
    """Return the errata list: what is printed, what is done instead, and why."""
    rows = tuple((e.id, e.where, e.statement, e.reading, e.evidence) for e in published.errata())
    return Table("Errata of the paper", ("Id", "Where", "Printed", "Read as", "Evidence"), rows)


def _printed(
    case: Case, theory: Model, ours: NDArray[np.float64], pick: list[int]
) -> list[tuple[Cell, ...]]:
    if not case.published or max(pick) > 5:
        return []
    rows: list[tuple[Cell, ...]] = []
    for method in ("FEA", "Theoretical", "Error (%)"):
        values = np.array(published.table1()[case.published, method])
        rows.append((case.name, f"printed: {method}", *cells(values[pick], PERCENT)))
    theoretical = np.array(published.table1()[case.published, "Theoretical"])
    deviation = relative_error(ours[pick], theoretical[pick])
    rows.append((case.name, f"{label(theory)} against printed (%)", *cells(deviation, signed=True)))
    return rows


def against_print(study: Study, theory: Model, printed: Sequence[Case]) -> list[str]:
    """Return how far `theory` is from the printed values, and which printed errors are wrong."""
    count = min(6, study.count)
    off = np.concatenate([
        relative_error(
            study.answers[case, theory].frequencies[:count],
            np.array(published.table1()[case.published, "Theoretical"])[:count],
        )
        for case in printed
    ])  # fmt: skip
    agreeing = int((np.abs(off) <= AGREES).sum())
    wrong = [mode for case in printed for mode in _not_following(case)]
    return [
        f"{agreeing} of the {len(off)} printed theoretical values agree with {label(theory)} at "
        f"the parameters read from the paper to {AGREES} %; ours lie {span(off, signed=True)} from "
        "them.",
        f"{len(wrong)} of the {6 * len(printed)} errors that Table I prints do not follow from the "
        f"digits of the two rows above them: {', '.join(wrong) or 'none'}.",
    ]


def _not_following(case: Case) -> list[str]:
    """Return the modes whose printed error is not 100 (theory - FEA) / FEA, rounded."""
    fea, ours, error = (
        np.array(published.table1()[case.published, row])
        for row in ("FEA", "Theoretical", "Error (%)")
    )
    # Half a unit of the last digit, and what binary fractions add to it.
    off = np.abs(relative_error(ours, fea) - error) > 0.00501
    return [f"f{i + 1} of {case.name}" for i in np.flatnonzero(off)]


def _errors(study: Study, model: Model, against: Model) -> NDArray[np.float64]:
    """Return the errors of `model` against another, (cases, count) [%], modes paired by shape."""
    rows = []
    for case in study.complete(model, against):
        pairing = study.pairing(case, model, against)
        assert pairing is not None, "both have an answer"
        exact = study.answers[case, against].frequencies[pairing.partner]
        rows.append(relative_error(study.answers[case, model].frequencies[: study.count], exact))
    return np.array(rows).reshape(len(rows), study.count)


def causes(study: Study, theory: Model) -> list[str]:
    """Return what the number of elements costs, and what the beam theory does."""
    limit = theory.limit()
    if limit is None:
        return []
    lines = []
    own = _errors(study, theory, limit)
    if theory != limit and own.size:
        worst = at_most(float(np.nanmax(np.abs(own))))
        lines.append(f"The number of elements ({label(theory)}) costs {worst}.")
    for richer in exact_chain(theory)[-1:]:
        beam = _errors(study, limit, richer)
        if beam.size and richer != limit:
            groups = [("f1-f3", beam[:, :3]), ("f4-f6", beam[:, 3:6])]
            costs = " and ".join(f"{span(part)} on {name}" for name, part in groups if part.size)
            lines.append(
                f"Beam theory ({label(limit)} against {label(richer)}, both without elements) "
                f"costs {costs}, and no number of elements removes that."
            )
    return lines


def _against_limit(study: Study, reference: Model) -> list[str]:
    """Return how far a simulator is from the exact limit of its own theory."""
    limit = reference.limit()
    if limit is None or limit == reference:
        return []
    errors = _errors(study, reference, limit)
    if not errors.size:
        return []
    worst = percent(float(np.nanmax(np.abs(errors))))
    return [f"{label(reference)} meets the exact limit of its own theory to {worst}."]


def closest_readings(readings: Sequence[Study]) -> list[str]:
    """Return which of the `readings` of the paper comes closest to each printed case."""
    worst: dict[str, list[tuple[float, Case]]] = {}
    for study in readings:
        for (case, _), modes in study.answers.items():
            printed = np.array(published.table1()[case.published, "Theoretical"])
            off = relative_error(modes.frequencies[:6], printed)
            worst.setdefault(case.published, []).append((float(np.abs(off).max()), case))
    lines = []
    for name, found in worst.items():
        off_by, case = min(found, key=lambda entry: entry[0])
        lines.append(
            f"{name}: of all readings tried here, {case.name} comes closest to the printed "
            f"theoretical values, to {percent(off_by)}: {case.note}."
        )
    return lines
