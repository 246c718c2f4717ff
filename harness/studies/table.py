"""Table I: every reference beside the theory, and both beside what the paper prints."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf, isnan, nan
from typing import Any

import numpy as np

from analytic.model import Model
from harness.bench import Bench, Study, label
from harness.case import Case
from harness.cases import PRESETS
from harness.causes import effects, exact_chain
from harness.compare import (
    at,
    case_notes,
    cell,
    cells,
    errors,
    failure_notes,
    largest,
    match,
    pairing_notes,
    percent,
    relative_error,
    span,
)
from harness.paper import TABLE_ONE, THEORETICAL, Printed
from harness.request import Plan, Request
from harness.result import Result
from harness.signatures import Array
from harness.tables import Number, Row, Table

STEM = "table1"
DEFAULTS = {"references": "usual"}
AGREES = 0.1
"""Two figures agree if they differ by no more than this [%]: ten times Table I's rounding, and,
beyond the last digit, what parameters rounded to three digits leave."""


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
    def taking(self) -> list[Model]:
        """The references that can take at least one of the cases."""
        return [
            model for model in self.references
            if any((case, model) not in self.study.refused for case in self.study.cases)
        ]  # fmt: skip

    def records(self) -> list[dict[str, Any]]:
        """Return one row a case, model and mode: `Study.rows` of the table itself."""
        return self.study.rows()

    def tables(self) -> dict[str, Table]:
        """Return Table I, every reference beside it, the readings, and where numbers come from."""
        cases = self.study.cases
        found = {"": self._table_one()}
        for theory in self.theories:
            ending = f"-{label(theory)}" if len(self.theories) > 1 else ""
            found[f"-references{ending}"] = self._references(theory)
        if any(case.printed and not case.prints_errors for case in cases):
            found["-printed"] = Table("Beside what is printed", (
                "Case", "Printed by", "Mode", "Printed [Hz]", "Model", "Ours [Hz]",
                "Difference [%]", "Where",
            ), [
                (case.name, one.method, f"f{one.mode}", Number(one.frequency), label(theory),
                 Number(ours), Number(off, 3, signed=True), one.where)
                for case in cases for theory in self.theories
                for one, ours, off in beside(self.study, case, theory)
            ])  # fmt: skip
        if self.readings:
            # Each case's own model against the printed Table I: no reading gives all of it.
            title = "Readings of the paper: theoretical values against the printed Table I"
            columns = ("Case", "Model", *(f"f{i} [%]" for i in range(1, 7)),
                       "What was read or fitted")  # fmt: skip
            found["-readings"] = Table(title, columns, [
                (case.name, label(case.theory), *cells(error, signed=True), case.note)
                for case, error in self._read()
            ])  # fmt: skip
            paper = next(case.paper for one in self.readings for case in one.cases if case.paper)
            columns = ("Id", "Where", "Printed", "Read as", "Evidence")
            found["-errata"] = Table("Errata of the paper", columns, [
                (e.id, e.where, e.statement, e.reading, e.evidence) for e in paper.errata
            ])  # fmt: skip
        columns = ("Case", "Model", "Theory", "Version", "dofs", "joint gap [m]")
        provenance = Table("Where the numbers come from", columns, [
            (case.name, label(model), modes.theory, modes.version, modes.dofs,
             "none can open" if modes.residual is None else f"{modes.residual:.0e}")
            for (case, model), modes in self.study.answers.items()
        ])  # fmt: skip
        return found | {"-seen": self._seen(), "-provenance": provenance}

    def _table_one(self) -> Table:
        """Return FEA, Theoretical and Error (%) of each pair, then what the paper prints.

        Modes are paired by shape; columns follow the theory's order.
        """
        rows, notes = list[Row](), list[str]()
        for case in self.study.cases:
            for theory in self.theories:
                for reference in self.references:
                    notes += pairing_notes(self.study, case, theory, reference, self.shown)
                rows += [(case.name, *row) for row in self._rows(case, theory)]
        notes += [f"{label(model)}: {remark}"
                  for model in self.taking if (remark := model.info().remark)]  # fmt: skip
        notes += case_notes(self.study.cases) + failure_notes(self.study)
        notes += [f"{name} cannot run here: {why}" for name, why in self.absent.items()]
        columns = ("Case", "Method", *(f"f{i} [Hz]" for i in self.shown))
        return Table("Table I: natural frequencies", columns, rows, list(dict.fromkeys(notes)))

    def _rows(self, case: Case, theory: Model) -> Iterator[Row]:
        for reference in self.references:
            found = match(self.study, case, theory, reference)
            if found is None:
                continue
            what = "Exact" if reference.elements is None else "FEA"
            yield f"{what} ({label(reference)})", *cells(at(found.against, self.shown), 3)
            yield f"Theoretical ({label(theory)})", *cells(at(found.ours, self.shown), 3)
            yield "Error (%)", *cells(at(found.error, self.shown), signed=True)
            if self.study.answers[case, reference].uncertainty is not None:
                yield f"{what}'s own uncertainty (%)", *cells(at(found.own, self.shown), 4)
        modes = self.study.get(case, theory)
        if modes is not None and case.prints_errors and max(self.shown) <= 6:
            for method in TABLE_ONE:
                yield f"printed: {method}", *cells(at(printed(case, method), self.shown))
            ours, theirs = (at(f, self.shown) for f in (modes.frequencies, printed(case)))
            off = cells(relative_error(ours, theirs), signed=True)
            yield f"{label(theory)} against printed (%)", *off

    def _references(self, theory: Model) -> Table:
        """Return one column a reference: its frequency, and the error of `theory` against it."""
        rows: list[Row] = []
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
        notes = [about, *failure_notes(self.study, of=self.taking)]
        return Table("Every reference beside the theory [Hz]", columns, rows, notes)

    def _read(self) -> Iterator[tuple[Case, Array]]:
        """Yield each case of the readings with its error against the printed values, (6,) [%]."""
        for study in self.readings:
            for (case, _), modes in study.answers.items():
                yield case, relative_error(modes.frequencies[:6], printed(case))

    def _seen(self) -> Table:
        """Return what each reference can see, what it cannot, and which cannot run here."""
        rows: list[Row] = []
        for model in self.taking:
            info = model.info()
            blind = [*effects(exact_chain(model)), "sections that warp" if info.limit else "",
                     "" if info.torsion else "limbs that twist alone", info.assumption]  # fmt: skip
            remarks = ["" if info.limit else "has no exact limit to be checked by", info.remark]
            said = ("; ".join(filter(None, some)) or "-" for some in (blind, remarks))
            program = f"{info.program} {info.version}".strip()
            rows.append((label(model), info.theory, program, *said))
        rows += [(name, "-", "cannot run here", "-", why) for name, why in self.absent.items()]
        columns = ("Reference", "What it sees of a rod", "Program", "What it does not see",
                   "Remark")  # fmt: skip
        return Table("What each reference can see", columns, rows)

    def sentences(self) -> list[str]:
        """Return what elements and theory cost, and what agrees with the printed table."""
        theory = self.theories[0]
        known = [case for case in self.study.complete(theory) if case.prints_errors]
        lines = causes(self.study, theory)
        lines += against_print(self.study, theory, known) if known else []
        lines += self._beside_papers(theory)
        for model in self.references:
            limit = model.limit()
            worst = nan if limit in (None, model) else largest(errors(self.study, model, limit))
            if not isnan(worst):
                lines.append(
                    f"{label(model)} meets the exact limit of its own theory to {percent(worst)}."
                )
        best: dict[str, tuple[float, Case]] = {}
        for case, error in self._read():
            off = largest(error)
            if off < best.get(case.published, (inf, case))[0]:
                best[case.published] = off, case
        return lines + [
            f"{name}: of all readings tried here, {case.name} comes closest to the printed "
            f"theoretical values, to {percent(off)}: {case.note}."
            for name, (off, case) in best.items()
        ]

    def _beside_papers(self, theory: Model) -> list[str]:
        """Return how many of the values of a paper and method a theory gives, and the worst."""
        seen: dict[tuple[str, str], list[tuple[bool, float]]] = {}
        for case in self.study.cases:
            for one, ours, off in beside(self.study, case, theory):
                good = abs(ours - one.frequency) <= one.half + AGREES / 100 * one.frequency
                if case.paper is not None:
                    seen.setdefault((case.paper.name, one.method), []).append((good, off))
        return [
            f"{sum(good for good, _ in some)} of the {len(some)} values that {paper} prints "
            f"({method}) agree with {label(theory)} to their last digit or {AGREES} %; the largest "
            f"difference is {max((off for _, off in some), key=abs):+.2f} %."
            for (paper, method), some in seen.items()
        ]


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


def beside(study: Study, case: Case, theory: Model) -> Iterator[tuple[Printed, float, float]]:
    """Yield the values printed of a case, the theory's [Hz], and its difference [%]."""
    modes = study.get(case, theory)
    for one in () if modes is None or case.prints_errors else case.printed:
        if one.mode <= study.count:
            ours = float(modes.frequencies[one.mode - 1])  # type: ignore[union-attr]
            yield one, ours, 100 * (ours / one.frequency - 1)


def against_print(study: Study, theory: Model, known: Sequence[Case]) -> list[str]:
    """Return how far `theory` is from the printed values, and which printed errors are wrong."""
    count, off, wrong = min(6, study.count), list[float](), list[str]()
    for case in known:
        ours = study.answers[case, theory].frequencies[:count]
        off += relative_error(ours, printed(case)[:count]).tolist()
        fea, theirs, error = (printed(case, row) for row in TABLE_ONE)
        # Half a unit of the last digit, and what binary fractions add to it.
        unlike = np.abs(relative_error(theirs, fea) - error) > 0.00501
        wrong += [f"f{i + 1} of {case.name}" for i in np.flatnonzero(unlike)]
    agreeing = sum(abs(one) <= AGREES for one in off)
    return [
        f"Of {len(off)} printed theoretical values {agreeing or 'none'} "
        f"{'agree' if agreeing > 1 else 'agrees'} with {label(theory)} to {AGREES} %.",
        f"At the parameters read from the paper {label(theory)} lies {span(off)} from "
        "the printed theoretical values.",
        f"{len(wrong)} of the {6 * len(known)} errors that Table I prints do not follow from the "
        f"digits of the two rows above them: {', '.join(wrong) or 'none'}.",
    ]


def causes(study: Study, theory: Model) -> list[str]:
    """Return what the number of elements costs, and what the beam theory does."""
    limit, lines = theory.limit(), list[str]()
    if limit is None:
        return lines
    richer = exact_chain(theory)[1:][-1:]
    beam = errors(study, limit, richer[0]) if richer else np.empty((0, 0))
    own = nan if limit == theory else largest(errors(study, theory, limit))
    if not isnan(own):
        one, most = theory.elements == 1, largest(beam)
        few, s = f"{theory.elements} element{'' if one else 's'} a limb", "s" if one else ""
        cost = f"cost{s} {percent(own, 'at most ')}"
        if not isnan(most):  # enough where they cost less than the beam theory does
            enough, less = ("enough", "less") if own < most else ("too few", "more")
            cost = f"{'is' if one else 'are'} {enough}: {'it' if one else 'they'} {cost}, {less} "
            cost += "than beam theory"
        lines.append(f"{few} {cost} ({label(theory)}).")
    parts = {"f1-f3": largest(beam[:, :3]), "f4-f6": largest(beam[:, 3:6])}
    told = [f"{percent(v, 'up to ')} on {name}" for name, v in parts.items() if not isnan(v)]
    if told:
        lines.append(
            f"Beam theory costs {' and '.join(told)}, and no number of elements removes that "
            f"({label(limit)} against {label(richer[0])})."
        )
    return lines
