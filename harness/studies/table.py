"""Table I: every reference beside the theory, and both beside what the paper prints."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from analytic.model import Model
from harness.bench import Bench, Study, label
from harness.case import Case
from harness.cases import PRESETS
from harness.causes import effects, exact_chain
from harness.compare import (
    PERCENT,
    at,
    case_notes,
    cell,
    cells,
    errors,
    failure_notes,
    kind,
    match,
    pairing_notes,
    percent,
    relative_error,
    span,
)
from harness.paper import TABLE_ONE, THEORETICAL, Paper
from harness.plan import Plan
from harness.printed import against_paper, printed_table
from harness.request import Request
from harness.result import Result
from harness.signatures import Array
from harness.tables import Cell, Number, Table

Rows = Iterator[tuple[Cell, ...]]
STEM = "table1"
DEFAULTS = {"references": "usual"}
AGREES = 0.1
"""Two sets of figures agree if none differs by more than this [%]: ten times Table I's rounding."""


def printed(case: Case, method: str = THEORETICAL) -> Array:
    """Return the row of Table I that `case` stands for, f1-f6 [Hz or %]."""
    assert case.paper is not None, "it is printed"
    return np.array(case.paper.row(case.published, method))


@dataclass(frozen=True)
class TableOne(Result):
    """Frequencies of `theories` and `references` at the cases of `study`.

    `shown`: mode numbers from 1; `readings`: other readings of the paper, each case by its own
    theory, where asked for; `absent`: why references cannot run here, by name.
    """

    study: Study
    theories: tuple[Model, ...]
    references: tuple[Model, ...]
    shown: tuple[int, ...]
    readings: tuple[Study, ...] = ()
    absent: Mapping[str, str] = field(default_factory=dict)

    @property
    def studies(self) -> tuple[Study, ...]:
        """What was solved for it."""
        return (self.study, *self.readings)

    @property
    def taking(self) -> tuple[Model, ...]:
        """The references that can take at least one of the cases."""
        refused = self.study.refused
        return tuple(
            model for model in self.references
            if not all((case, model) in refused for case in self.study.cases)
        )  # fmt: skip

    def records(self) -> list[dict[str, Any]]:
        """Return one row a case, model and mode: `Study.rows` of the table itself."""
        return self.study.rows()

    def tables(self) -> dict[str, Table]:
        """Return Table I, every reference beside it, the readings, and where numbers come from."""
        found = {"": self._table_one()}
        for theory in self.theories:
            ending = f"-{label(theory)}" if len(self.theories) > 1 else ""
            found[f"-references{ending}"] = self._references(theory)
        if any(case.printed and not case.prints_errors for case in self.study.cases):
            found["-printed"] = printed_table(self.study, self.theories)
        if self.readings:
            found["-readings"] = readings_table(self.readings)
            papers = (case.paper for one in self.readings for case in one.cases if case.paper)
            found["-errata"] = errata_table(next(papers))
        found["-seen"] = seen_table(self.taking, self.absent)
        return found | {"-provenance": provenance_table(self.study)}

    def _table_one(self) -> Table:
        """Return FEA, Theoretical and Error (%) of each pair, then what the paper prints.

        Modes are paired by shape; columns follow the theory's order.
        """
        rows, notes = [], []
        for case in self.study.cases:
            for theory in self.theories:
                for reference in self.references:
                    rows += list(self._pair(case, theory, reference))
                    notes += pairing_notes(self.study, case, theory, reference, self.shown)
                rows += list(self._printed(case, theory))
        notes += [
            f"{label(model)}: {remark}"
            for model in self.taking if (remark := model.info().remark)
        ]  # fmt: skip
        notes += case_notes(self.study.cases) + failure_notes(self.study)
        notes += [f"{name} cannot run here: {why}" for name, why in self.absent.items()]
        columns = ("Case", "Method", *(f"f{i} [Hz]" for i in self.shown))
        title = "Table I: natural frequencies"
        return Table(title, columns, tuple(rows), tuple(dict.fromkeys(notes)))

    def _pair(self, case: Case, theory: Model, reference: Model) -> Rows:
        found, what = match(self.study, case, theory, reference), kind(reference)
        if found is None:
            return
        f, ours, error, own = (
            at(v, self.shown) for v in (found.against, found.ours, found.error, found.own)
        )
        yield case.name, f"{what} ({label(reference)})", *cells(f, 3)
        yield case.name, f"Theoretical ({label(theory)})", *cells(ours, 3)
        yield case.name, "Error (%)", *cells(error, signed=True)
        if self.study.answers[case, reference].uncertainty is not None:
            yield case.name, f"{what}'s own uncertainty (%)", *cells(own, 4)

    def _printed(self, case: Case, theory: Model) -> Rows:
        ours = self.study.get(case, theory)
        if ours is None or not case.prints_errors or max(self.shown) > 6:
            return
        for method in TABLE_ONE:
            values = cells(at(printed(case, method), self.shown), PERCENT)
            yield case.name, f"printed: {method}", *values
        off = relative_error(at(ours.frequencies, self.shown), at(printed(case), self.shown))
        yield case.name, f"{label(theory)} against printed (%)", *cells(off, signed=True)

    def _references(self, theory: Model) -> Table:
        """Return one column a reference: its frequency, and the error of `theory` against it."""
        rows: list[tuple[Cell, ...]] = []
        for case in self.study.complete(theory):
            ours = self.study.answers[case, theory].frequencies
            found = {model: match(self.study, case, theory, model) for model in self.taking}
            for i in self.shown:
                said = []
                for model, one in found.items():
                    if one is None:
                        refused = (case, model) in self.study.refused
                        said.append("cannot take it" if refused else "failed")
                        continue
                    error = cell(one.error[i - 1], 3, signed=True)
                    unit, mark = "" if error == "-" else " %", " *" if one.odd[i - 1] else ""
                    said.append(f"{one.against[i - 1]:.3f} ({error}{unit}){mark}")
                rows.append((case.name, f"f{i}", Number(float(ours[i - 1])), *said))
        about = "in brackets: error of the theoretical value; *: paired by shape against the order"
        columns = ("Case", "Mode", label(theory), *map(label, self.taking))
        notes = (about, *failure_notes(self.study, of=self.taking))
        return Table("Every reference beside the theory [Hz]", columns, tuple(rows), notes)

    def sentences(self) -> list[str]:
        """Return what elements and theory cost, and what agrees with the printed table."""
        theory = self.theories[0]
        known = [case for case in self.study.complete(theory) if case.prints_errors]
        lines = causes(self.study, theory)
        lines += against_print(self.study, theory, known) if known else []
        lines += against_paper(self.study, theory)
        for model in self.references:
            limit = model.limit()
            if limit is None or limit == model:
                continue
            worst = _largest(errors(self.study, model, limit))
            if worst is not None:
                lines.append(
                    f"{label(model)} meets the exact limit of its own theory to {percent(worst)}."
                )
        return lines + closest_readings(self.readings)


def run(request: Request, bench: Bench) -> TableOne:
    """Return Table I; with `elements`, one theory for each of them."""
    theories = [request.theory]
    if request.elements is not None:
        theories = [replace(request.theory, elements=s) for s in request.elements]
    some = [*theories, *request.references]
    limits = [limit for model in some if (limit := model.limit()) is not None]
    models = [*some, *limits, *exact_chain(theories[0])[-1:]]
    study = bench.run(request.cases, models, request.count)
    asked = PRESETS.values() if request.options.get("readings") else ()
    readings = tuple(bench.run([case], [case.theory], 6) for case in asked)
    known = request.references
    return TableOne(study, tuple(theories), known, request.shown, readings, request.absent)


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: also every reading of the paper, if its cases are asked."""
    paper = any(case.prints_errors for case in plan.cases)
    return {"table1": plan.request(options={"readings": paper})}


def readings_table(readings: Sequence[Study]) -> Table:
    """Return each case's own model against the printed Table I [%]: no reading gives all of it."""
    rows = tuple(
        (case.name, label(case.theory), *cells(error, signed=True), case.note)
        for case, error in _readings(readings)
    )
    columns = ("Case", "Model", *(f"f{i} [%]" for i in range(1, 7)), "What was read or fitted")
    title = "Readings of the paper: theoretical values against the printed Table I"
    return Table(title, columns, rows)


def _readings(readings: Sequence[Study]) -> Iterator[tuple[Case, Array]]:
    """Yield each case with its error against the printed values, (6,) [%]."""
    for study in readings:
        for (case, _), modes in study.answers.items():
            yield case, relative_error(modes.frequencies[:6], printed(case))


def provenance_table(study: Study) -> Table:
    """Return where every number comes from: theory, version, coordinates and joint gap a case."""
    rows = tuple(
        (case.name, label(model), modes.theory, modes.version, modes.dofs,
         "none can open" if modes.residual is None else f"{modes.residual:.0e}")
        for (case, model), modes in study.answers.items()
    )  # fmt: skip
    columns = ("Case", "Model", "Theory", "Version", "dofs", "joint gap [m]")
    return Table("Where the numbers come from", columns, rows)


def seen_table(references: Sequence[Model], absent: Mapping[str, str]) -> Table:
    """Return what each reference can see, and what it cannot; `absent`: those that cannot run."""
    rows = []
    for model in references:
        info = model.info()
        blind = [*effects(exact_chain(model)), "sections that warp" if info.limit else "",
                 "" if info.torsion else "limbs that twist alone", info.assumption]  # fmt: skip
        remarks = ["" if info.limit else "has no exact limit to be checked by", info.remark]
        said = ("; ".join(filter(None, some)) or "-" for some in (blind, remarks))
        rows.append((label(model), info.theory, f"{info.program} {info.version}".strip(), *said))
    rows += [(name, "-", "cannot run here", "-", why) for name, why in absent.items()]
    columns = ("Reference", "What it sees of a rod", "Program", "What it does not see", "Remark")
    return Table("What each reference can see", columns, tuple(rows))


def errata_table(paper: Paper) -> Table:
    """Return the errata list: what is printed, what is done instead, and why."""
    rows = tuple((e.id, e.where, e.statement, e.reading, e.evidence) for e in paper.errata)
    return Table("Errata of the paper", ("Id", "Where", "Printed", "Read as", "Evidence"), rows)


def against_print(study: Study, theory: Model, known: Sequence[Case]) -> list[str]:
    """Return how far `theory` is from the printed values, and which printed errors are wrong."""
    count = min(6, study.count)
    off = np.concatenate([
        relative_error(study.answers[case, theory].frequencies[:count], printed(case)[:count])
        for case in known
    ])  # fmt: skip
    agreeing = int((np.abs(off) <= AGREES).sum())
    wrong = [mode for case in known for mode in _not_following(case)]
    return [
        f"Of {len(off)} printed theoretical values {agreeing or 'none'} "
        f"{'agree' if agreeing > 1 else 'agrees'} with {label(theory)} to {AGREES} %.",
        f"At the parameters read from the paper {label(theory)} lies {span(off, signed=True)} from "
        "the printed theoretical values.",
        f"{len(wrong)} of the {6 * len(known)} errors that Table I prints do not follow from the "
        f"digits of the two rows above them: {', '.join(wrong) or 'none'}.",
    ]


def _not_following(case: Case) -> list[str]:
    """Return the modes whose printed error is not 100 (theory - FEA) / FEA, rounded."""
    fea, ours, error = (printed(case, row) for row in TABLE_ONE)
    # Half a unit of the last digit, and what binary fractions add to it.
    off = np.abs(relative_error(ours, fea) - error) > 0.00501
    return [f"f{i + 1} of {case.name}" for i in np.flatnonzero(off)]


def _largest(errors: Array) -> float | None:
    """Return the largest error without its sign; None where there is none."""
    known = np.abs(errors[np.isfinite(errors)])
    return float(known.max()) if known.size else None


def causes(study: Study, theory: Model) -> list[str]:
    """Return what the number of elements costs, and what the beam theory does."""
    limit, lines = theory.limit(), list[str]()
    if limit is None:
        return lines
    richer = exact_chain(theory)[1:][-1:]
    beam = errors(study, limit, richer[0]) if richer else np.empty((0, 0))
    own = None if limit == theory else _largest(errors(study, theory, limit))
    if own is not None:
        lines.append(_of_elements(theory, own, _largest(beam)))
    parts = {"f1-f3": _largest(beam[:, :3]), "f4-f6": _largest(beam[:, 3:6])}
    told = [f"{percent(v, 'up to ')} on {name}" for name, v in parts.items() if v is not None]
    if told:
        lines.append(
            f"Beam theory costs {' and '.join(told)}, and no number of elements removes that "
            f"({label(limit)} against {label(richer[0])})."
        )
    return lines


def _of_elements(theory: Model, own: float, beam: float | None) -> str:
    """Return whether elements are enough: whether they cost less than the beam theory does [%]."""
    one = theory.elements == 1
    few = f"{theory.elements} element{'' if one else 's'} a limb"
    cost = f"{'it costs' if one else 'they cost'} {percent(own, 'at most ')}"
    name = label(theory)
    if beam is None:
        return f"{few} {'costs' if one else 'cost'} {percent(own, 'at most ')} ({name})."
    if own < beam:
        return f"{few} {'is' if one else 'are'} enough: {cost}, less than beam theory ({name})."
    return f"{few} {'is' if one else 'are'} too few: {cost}, more than beam theory ({name})."


def closest_readings(readings: Sequence[Study]) -> list[str]:
    """Return which of the `readings` of the paper comes closest to each printed case."""
    best: dict[str, tuple[float, Case]] = {}
    for case, error in _readings(readings):
        off = float(np.abs(error).max())
        if off < best.get(case.published, (np.inf, case))[0]:
            best[case.published] = off, case
    return [
        f"{name}: of all readings tried here, {case.name} comes closest to the printed "
        f"theoretical values, to {percent(off)}: {case.note}."
        for name, (off, case) in best.items()
    ]
