"""Sections of one run: claims, Table I, Fig. 3, budget, precision, shapes, and all that tables say.

Each returns what its template and its script show, or None where the run has nothing of it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from analytic.model import Model
from harness.bench import label
from harness.case import Case
from harness.compare import PERCENT, at, match, relative_error
from harness.drawing import AMPLITUDE, drawn, scale
from harness.paper import CHECKED, TABLE_ONE
from harness.report.section import Json, Material, Section, answer, digits, number, shown
from harness.rows import mode_rows
from harness.studies.budget import ELEMENTS, Budget
from harness.studies.claims import verb
from harness.studies.convergence import Convergence
from harness.studies.precision import GROUPS, Point, WorkPrecision
from harness.studies.table import TableOne, printed

VERDICTS = ("fails", "cannot be reproduced", "holds only if", "holds")
"""Kinds of verdicts as they begin, what a reader looks for first."""
CLAIM = {
    "Where": "section", "Printed": "quoted", "Checked": "how", "Measured": "measured",
    "Uncertainty": "uncertainty", "Verdict": "verdict", "Command": "command",
}  # fmt: skip
"""What is said of a claim, and its column in the study of claims."""
HZ, PERCENTS = ".3f", f"+.{PERCENT}f"
"""How frequencies and errors are written."""
MEANING = {
    ELEMENTS: "the theory with s elements less the same theory without any",
    "rotary inertia": "exact Euler-Bernoulli less exact Rayleigh",
    "shear": "exact Rayleigh less exact Timoshenko",
}
DRAWN = "starts", "tips", "centre", "axes", "radius", "ground"
"""What the page needs of what is drawn, beside spans and marks."""
MODELS = {
    "Case": False, "Model": False, "Theory": False, "Version": False, "Coordinates": True,
    "Joint gap": True, "Uncertainty of f1 [%]": True, "Time": False,
}  # fmt: skip
"""What is said of every model, and whether it is a number."""


def verdicts(run: Material) -> list[Json]:
    """Return the claims of the run: columns of `CLAIM` and the id, and the `kind` of verdict."""
    return [
        {
            "id": row["id"],
            **{name: row[name] for name in CLAIM.values()},
            "kind": next(kind for kind in VERDICTS if row["verdict"].startswith(kind)),
        }
        for result in run.part("claims").results.values()
        for row in result.to_frame().to_dict("records")
    ]


def claims(run: Material) -> Section | None:
    """Return the paper's claims and their verdicts, as the study of claims judged them."""
    found = verdicts(run)
    for claim in found:
        fields = {heading: claim[name] for heading, name in CLAIM.items()}
        claim["record"] = run.note(f"Claim {claim['id']}", fields)
        claim["verdict"], _, claim["why"] = claim["verdict"].partition(": ")
    kinds = {kind: [one for one in found if one["kind"] == kind] for kind in VERDICTS}
    groups = [[kind, own, verb(kind, len(own))] for kind, own in kinds.items() if own]
    return Section({"count": len(found), "groups": groups}) if found else None


def table_one(run: Material) -> Section | None:
    """Return what the paper prints, the theory, and every reference with the error against it."""
    table = run.one(TableOne)
    if table is None:
        return None
    cases = [
        {"name": case.name, "heading": case.heading, "rows": [*_rows(run, table, case)]}
        for case in table.study.cases
    ]
    columns = [f"f{i} [Hz]" for i in table.shown]
    notes = list(table.table().notes)
    return Section(
        {"columns": columns, "cases": cases, "sentences": table.sentences(), "notes": notes}
    )


def _rows(run: Material, table: TableOne, case: Case) -> Iterator[Json]:
    def row(head: str, about: str, kind: str, cells: Sequence[Any]) -> Json:
        return {"head": head, "about": about, "kind": kind, "cells": cells}

    def shown(values: Any, form: str, unit: str, what: str, record: int | None,
              marks: Sequence[str] = ()) -> list[Any]:  # fmt: skip
        """Return values of the modes shown as numbers, with `marks`; a dash for what is none."""
        return [
            number(f"{values[i - 1]:{form}}{marks[i - 1] if marks else ''}",
                   f"{float(values[i - 1])!r} {unit}", f"f{i}: {what}, {case.name}", record)
            if i <= len(values) and np.isfinite(values[i - 1]) else "-" for i in table.shown
        ]  # fmt: skip

    def errors(values: Any, what: str, made: str, *parts: int | None, marks: Any = ()) -> list[Any]:
        """Return errors that were `made` of the answers `parts`."""
        fields = {"Made as": made, "Command": run.only("table")}
        record = run.note(f"{what}, {case.name}", fields, *parts)
        return shown(values, PERCENTS, "%", what, record, marks)

    for method in TABLE_ONE if case.prints_errors else ():
        source = {"File": f"results/published/{CHECKED}/table.csv", "Where": "Table I of the paper"}
        page = run.ledger.add(f"Printed: {method}, {case.published}", source)
        unit = "%" if "%" in method else "Hz"
        cells = shown(printed(case, method), ".2f", unit, f"{method} as printed", page)
        yield row(f"printed: {method}", "", "printed", cells)
    for theory in table.theories:
        ours = table.study.first(case, theory)
        if ours is None:
            continue
        name, record = label(theory), run.record(case, theory)
        yield row(name, ours.theory, "theory", shown(ours.frequencies, HZ, "Hz", name, record))
        if case.prints_errors:
            count = min(len(ours.frequencies), len(printed(case)))
            off = relative_error(ours.frequencies[:count], printed(case)[:count])
            what = f"{name} against printed (%)"
            made = "100 (theoretical / printed theoretical - 1)"
            yield row(what, "", "printed", errors(off, what, made, record))
        for reference in table.references:
            found = match(table.study, case, theory, reference)
            if found is None:
                continue
            other, own = label(reference), run.record(case, reference)
            what = f"error of {name} against {other}"
            made = "100 (theoretical / reference - 1), modes paired by shape"
            marks = np.where(found.odd, " % *", " %").tolist()
            hertz = shown(found.against, HZ, "Hz", other, own)
            pairs = zip(
                hertz, errors(found.error, what, made, record, own, marks=marks), strict=True
            )
            against = table.study.answers[case, reference]
            yield row(
                other,
                f"{against.theory}; {against.version}",
                "reference",
                [{"value": value, "error": error} for value, error in pairs],
            )


def fig3(run: Material) -> Section | None:
    """Return the error against elements: every family of models against every reference."""
    found = run.of(Convergence)
    if not found:
        return None
    cases = {case.name: _curves(run, case) for case in run.plan.cases}
    cases = {name: one for name, one in cases.items() if one["families"] and one["references"]}
    if not cases:
        return Section(missing="no model has an answer")
    data = {
        "elements": list(run.plan.elements),
        "modes": list(run.plan.shown),
        "cases": cases,
        "command": run.only("convergence,table"),
    }
    return Section({"sentences": [line for result in found for line in result.sentences()]}, data)


def _curves(run: Material, case: Case) -> Json:
    def errors(model: Model | None) -> Json:
        """Return 100 (f / f_reference - 1) [%] of the modes shown, by reference; or None."""
        return {label(one): off(model, one) for one in references}

    def off(model: Model | None, reference: Model) -> list[float | None] | None:
        short = len(run.answers[case, reference].frequencies) < run.plan.count
        found = None if short or model is None else match(run.study, case, model, reference)
        return None if found is None else digits(at(found.error, run.plan.shown), 8)

    references = run.references(case)
    families = {}
    for name, meshes in run.families(case).items():
        limit = next(iter(meshes.values())).limit()
        models = [meshes.get(s) for s in run.plan.elements]
        rows = [errors(model) for model in models]
        families[name] = {
            "records": [run.record(case, model) for model in models],
            "labels": [label(model) if model else "" for model in models],
            "errors": {label(one): [row[label(one)] for row in rows] for one in references},
            "floors": errors(limit),
            "limit": label(limit) if limit else None,
        }
    described = {}
    for one in references:
        modes = run.answers[case, one]
        own = None if modes.uncertainty is None else 100 * modes.uncertainty / modes.frequencies
        described[label(one)] = {
            "theory": modes.theory,
            "uncertainty": None if own is None else digits(at(own, run.plan.shown), 4),
            "record": run.record(case, one),
        }
    quoted = case.paper.errors.items() if case.paper else ()
    return {
        "heading": case.heading,
        "families": families,
        "references": described,
        "printed": [[s, i, error] for (name, s, i), error in quoted if name == case.published],
    }


def budget(run: Material) -> Section | None:
    """Return the parts that add up to the paper's one "error (%)"."""
    found = [one for one in run.of(Budget) if one.shares]
    if not found:
        return None
    found.sort(key=lambda one: one.reference != run.plan.solid)
    data = [_budget(run, one) for one in found]
    context = {
        "sentences": [line for one in found for line in one.sentences()],
        "tables": [shown(one.table()) for one in found],
    }
    return Section(context, data)


def _budget(run: Material, one: Budget) -> Json:
    cases = {}
    for case, shares in one.shares.items():
        records = []
        for s in one.elements:
            mesh = replace(one.theory, elements=s)
            parts = [run.record(case, model) for model in (mesh, one.reference)]
            where = f"s = {s}, against {label(one.reference)}"
            records.append([
                run.note(
                    f"Error budget, {case.name}: {part}, {where}",
                    {"What": MEANING.get(part, "in points of the reference's frequency"),
                     "Command": run.only("budget")}, *parts,
                )
                for part in (*one.parts, "total error")
            ])  # fmt: skip
        cases[case.name] = {
            "shares": digits(at(shares, one.shown), 8),
            "total": digits(at(shares.sum(axis=1), one.shown), 8),
            "band": digits(at(one.band(case, one.reference), one.shown), 4),
            "records": records,
        }
    return {
        "theory": one.theory.name, "reference": label(one.reference), "parts": list(one.parts),
        "elements": list(one.elements), "modes": list(one.shown), "cases": cases,
    }  # fmt: skip


def precision(run: Material) -> Section | None:
    """Return what an accuracy costs, model by model."""
    found = run.one(WorkPrecision)
    if found is None:
        return None
    data = {
        "rows": [_point(run, found, point) for point in found.points],
        "kinds": list(found.kinds.values()),
        "groups": list(GROUPS),
    }
    context = {
        "sentences": found.sentences(),
        "tables": [shown(table) for table in found.tables().values()],
        "cases": ", ".join(case.name for case in found.cases),
    }
    return Section(context, data)


def _point(run: Material, found: WorkPrecision, point: Point) -> Json:
    info = point.model.info()
    fields = {
        "Way": point.name,
        "Theory": info.theory,
        "Version": f"{info.program} {info.version}".strip(),
        "Coordinates": "" if point.dofs is None else str(point.dofs),
        "Timed": f"{found.timings.rounds} rounds, the median; one thread",
        "Command": run.only("work-precision"),
    }
    worst = [[point.worst(kind, modes) for modes in GROUPS.values()] for kind in found.kinds]
    return {
        "method": point.method, "size": point.size, "theory": info.theory,
        "ms": digits(1e3 * point.seconds, 4), "errors": digits(worst, 5),
        "record": run.note(f"{point.method}, elements {point.size}", fields),
    }  # fmt: skip


def shapes(run: Material) -> Section | None:
    """Return modes that turn and move: of the theory, its exact limits, and every reference."""
    data = {}
    for case in run.plan.cases:
        meshes = next(iter(run.families(case).values()), {})
        wanted = dict.fromkeys([run.plan.theory, *run.references(case), *meshes.values()])
        models = [model for model in wanted if (case, model) in run.answers]
        if models:
            there = drawn(case.mechanism, case.pose)
            marks = () if there.plain else there.marks
            data[case.name] = {
                **{name: _rounded(getattr(there, name)) for name in DRAWN},
                "spans": [[s.limb, *_rounded([s.begin, s.end, s.radius])] for s in there.spans],
                "marks": [
                    {"kind": m.kind, "limb": m.limb, "place": m.place, "beside": _rounded(m.beside)}
                    for m in marks
                ],
                "models": {label(model): _moved(run, case, model) for model in models},
            }
    said = run.part("shapes").sentences()
    context = {"modes": run.plan.count, "amplitude": AMPLITUDE, "sentences": said}
    return Section(context, data) if data else None


def _moved(run: Material, case: Case, model: Model) -> Json:
    modes = run.answers[case, model].first(run.plan.count)
    enlarged = scale(drawn(case.mechanism, case.pose), modes.limbs)
    return {
        "f": digits(modes.frequencies),
        "platform": _rounded(enlarged[:, None] * modes.platform),
        "limbs": _rounded(enlarged[:, None, None, None] * modes.limbs),
        "record": run.record(case, model),
    }


def _rounded(values: Any) -> Any:
    """Return lengths to a hundredth of a millimetre: more cannot be seen."""
    return np.round(values, 5).tolist()


def other(run: Material, name: str) -> Section | None:
    """Return what a study without a picture of its own says, and its tables."""
    part = run.part(name)
    if not part.results:
        return Section(missing=f"not made: {part.why}") if part.why else None
    record = run.note(part.entry.title, {"Command": run.only(name)})
    tables = [one for result in part.results.values() for one in result.tables().values()]
    return Section(
        {"sentences": part.sentences(), "tables": [shown(one, record) for one in tables]}
    )


def provenance(run: Material) -> Section | None:
    """Return every model with an answer: its version, size, joint gap and cost."""
    left = {what: why for one in run.results for what, why in one.failures().items()}
    left |= {part.entry.title: part.why for part in run.parts if part.why}
    if not run.answers and not left:
        return None
    rows = []
    for case in run.plan.cases:
        for model in run.models(case):
            modes, name = run.answers[case, model], label(model)
            own = modes.uncertainty
            percent = "" if own is None else f"{100 * own[0] / modes.frequencies[0]:.2g}"
            known = number(name, "", f"{name} at {case.name}", run.record(case, model))
            said = {
                **answer(mode_rows(case, name, "", modes, 1)),
                "Case": case.name,
                "Model": known,
                "Uncertainty of f1 [%]": percent,
            }
            rows.append([said[column] for column in MODELS])
    title = "Every model of the run; uncertainty is the numerical one, by extrapolation"
    table = {
        "title": title,
        "columns": [*MODELS],
        "numeric": [*MODELS.values()],
        "rows": rows,
        "notes": [],
    }
    return Section({"table": table, "failures": [f"{what}: {why}" for what, why in left.items()]})
