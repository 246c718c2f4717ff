"""Tables that set models beside each other and beside the paper: Table I and its companions."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analytic.pairing import Pairing
from harness import published
from harness.cases import Case
from harness.models import MADE_FROM, SOLID_LIMB, Spec
from harness.run import Study
from harness.tables import Cell, Number, Table

PERCENT = 2  # decimals, as in Table I


def relative_error(
    theory: NDArray[np.float64], reference: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return 100 (theory / reference - 1) [%], the paper's "Error (%)"."""
    return np.asarray(100 * (theory / reference - 1))


def table_one(
    study: Study, theories: Sequence[Spec], references: Sequence[Spec], shown: Sequence[int]
) -> Table:
    """Return Table I: FEA, Theoretical and Error (%) of each pair, then what the paper prints.

    `shown` are mode numbers from 1. Modes are paired by shape; columns follow the theory's order.
    """
    rows: list[tuple[Cell, ...]] = []
    notes: list[str] = []
    pick = [i - 1 for i in shown]
    for case in study.cases:
        for theory in theories:
            ours = study.get(case, theory)
            if ours is None:
                continue
            for reference in references:
                against, pairing = (
                    study.get(case, reference),
                    study.pairing(case, theory, reference),
                )
                if against is None or pairing is None:
                    continue
                fea = against.frequencies[pairing.partner]
                error = relative_error(ours.frequencies[: study.count], fea)
                rows.append((case.name, f"FEA ({reference.label})", *_numbers(fea, pick)))
                rows.append(
                    (case.name, f"Theoretical ({theory.label})", *_numbers(ours.frequencies, pick))
                )
                rows.append((case.name, "Error (%)", *_percent(error, pick)))
                if against.uncertainty is not None:
                    own = 100 * against.uncertainty[pairing.partner] / fea
                    rows.append((case.name, "FEA's own uncertainty (%)", *_numbers(own, pick, 4)))
                notes += pairing_notes(case, theory, reference, pairing, pick)
            rows += _printed(case, theory, ours.frequencies, pick)
    if any(reference.name == SOLID_LIMB for reference in references):
        notes.append(f"{SOLID_LIMB}: uncertainty of interpolation only; its mesh is {MADE_FROM}'s")
    notes += case_notes(study.cases) + failure_notes(study)
    columns = ("Case", "Method", *(f"f{i} [Hz]" for i in shown))
    return Table("Table I: natural frequencies", columns, tuple(rows), tuple(dict.fromkeys(notes)))


def _printed(
    case: Case, theory: Spec, ours: NDArray[np.float64], pick: list[int]
) -> list[tuple[Cell, ...]]:
    if not case.published or max(pick) > 5:
        return []
    rows: list[tuple[Cell, ...]] = []
    for method in ("FEA", "Theoretical", "Error (%)"):
        values = np.array(published.table1()[case.published, method])
        rows.append((case.name, f"printed: {method}", *_numbers(values, pick, PERCENT)))
    theoretical = np.array(published.table1()[case.published, "Theoretical"])
    deviation = relative_error(ours[pick], theoretical[pick])
    label = f"{theory.label} against printed (%)"
    rows.append((case.name, label, *_percent(deviation, range(len(pick)))))
    return rows


def reference_table(
    study: Study, theory: Spec, references: Sequence[Spec], shown: Sequence[int]
) -> Table:
    """Return one column a reference: its frequency, and the error of `theory` against it [%]."""
    rows: list[tuple[Cell, ...]] = []
    for case in study.cases:
        ours = study.get(case, theory)
        if ours is None:
            continue
        pairings = [study.pairing(case, theory, reference) for reference in references]
        for i in shown:
            row: list[Cell] = [case.name, f"f{i}", Number(float(ours.frequencies[i - 1]))]
            for reference, pairing in zip(references, pairings, strict=True):
                against = study.get(case, reference)
                if against is None or pairing is None:
                    row.append("failed")
                    continue
                fea = float(against.frequencies[pairing.partner[i - 1]])
                error = 100 * (float(ours.frequencies[i - 1]) / fea - 1)
                mark = " *" if pairing.reordered[i - 1] or pairing.doubtful[i - 1] else ""
                row.append(f"{fea:.3f} ({error:+.3f} %){mark}")
            rows.append(tuple(row))
    notes = ["in brackets: error of the theoretical value; *: paired by shape against the order"]
    title = "Every reference beside the theory [Hz]"
    columns = ("Case", "Mode", theory.label, *(reference.label for reference in references))
    return Table(title, columns, tuple(rows), tuple(notes + failure_notes(study)))


def readings_table(studies: Sequence[Study]) -> Table:
    """Return each case's own model against the printed Table I [%]: no reading gives all of it."""
    rows: list[tuple[Cell, ...]] = []
    for study in studies:
        for case, spec in zip(study.cases, study.specs, strict=True):
            printed = np.array(published.table1()[case.published, "Theoretical"])
            error = relative_error(study.modes[case.name, spec.label].frequencies[:6], printed)
            rows.append((case.name, spec.label, *_percent(error, range(6)), case.note))
    columns = ("Case", "Model", *(f"f{i} [%]" for i in range(1, 7)), "What was read or fitted")
    title = "Readings of the paper: theoretical values against the printed Table I"
    return Table(title, columns, tuple(rows))


def provenance_table(study: Study) -> Table:
    """Return where every number comes from: theory, version, size, closure and cost a case."""
    rows: list[tuple[Cell, ...]] = []
    for case in study.cases:
        for spec in study.specs:
            modes = study.get(case, spec)
            if modes is None:
                continue
            closed = "none can open" if modes.residual is None else f"{modes.residual:.0e}"
            rows.append(
                (case.name, spec.label, modes.theory, modes.version, modes.dofs, closed,
                 Number(1000 * modes.build_seconds, 1), Number(1000 * modes.solve_seconds, 1))
            )  # fmt: skip
    columns = (
        "Case",
        "Model",
        "Theory",
        "Version",
        "dofs",
        "joint gap [m]",
        "build [ms]",
        "solve [ms]",
    )
    return Table("Where the numbers come from", columns, tuple(rows))


def errata_table() -> Table:
    """Return the errata list: what is printed, what is done instead, and why."""
    rows = tuple((e.id, e.where, e.statement, e.reading, e.evidence) for e in published.errata())
    return Table("Errata of the paper", ("Id", "Where", "Printed", "Read as", "Evidence"), rows)


def case_notes(cases: Sequence[Case]) -> list[str]:
    """Return what was read or fitted in each case, and the errata that explain it."""
    notes = [f"{case.name}: {case.note}" for case in cases]
    wanted = {key for case in cases for key in case.errata}
    return notes + [
        f"erratum {erratum.id} ({erratum.where}): {erratum.evidence}"
        for erratum in published.errata()
        if erratum.id in wanted
    ]


def pairing_notes(
    case: Case, theory: Spec, reference: Spec, pairing: Pairing, pick: Sequence[int]
) -> list[str]:
    """Return a sentence for every mode whose partner is not the one its order suggests."""
    notes = []
    for i in pick:
        where = f"{case.name}: mode {i + 1} of {theory.label}"
        seen = f"(assurance {pairing.assurance[i]:.3f})"
        if pairing.reordered[i]:
            other = int(pairing.partner[i]) + 1
            notes.append(
                f"{where} looks like mode {other} of {reference.label} {seen}: paired by shape"
            )
        elif pairing.doubtful[i]:
            notes.append(
                f"{where} looks like no mode of {reference.label} {seen}: its error is doubtful"
            )
    return notes


def failure_notes(study: Study) -> list[str]:
    """Return a sentence for every model that failed at a case."""
    return [f"{label} failed at {case}: {why}" for (case, label), why in study.failures.items()]


def _numbers(values: NDArray[np.float64], pick: Sequence[int], digits: int = 3) -> list[Number]:
    return [Number(float(values[i]), digits) for i in pick]


def _percent(values: NDArray[np.float64], pick: Sequence[int]) -> list[Number]:
    return [Number(float(values[i]), PERCENT, signed=True) for i in pick]
