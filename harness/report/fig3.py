"""Fig. 3: error against the number of elements, with the floor that no number removes."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.model import Model
from analytic.pairing import pair
from harness import published
from harness.bench import label
from harness.cases import Case
from harness.compare import relative_error
from harness.report.material import Material
from harness.report.section import Json, Section, digits
from harness.studies.convergence import Convergence

KEY, TITLE, MENU = "fig3", "Fig. 3: error against the number of elements", "Fig. 3"


def section(run: Material) -> Section | None:
    """Return the section: every family of models against every reference of the run."""
    found = run.of(Convergence)
    if not found:
        return None
    cases = {case.name: _case(run, case) for case in run.plan.cases}
    cases = {name: one for name, one in cases.items() if one["families"] and one["references"]}
    if not cases:
        return Section(KEY, TITLE, MENU, run.only("convergence"), missing="no model has an answer")
    command = f"{run.only('convergence')},table"
    data = {"elements": list(run.plan.elements), "modes": list(run.plan.shown), "cases": cases,
            "command": command}  # fmt: skip
    context = {
        "cases": list(cases),
        "families": list(dict.fromkeys(name for one in cases.values() for name in one["families"])),
        "references": list(
            dict.fromkeys(name for one in cases.values() for name in one["references"])
        ),
        "modes": list(run.plan.shown),
        "printed": any(one["printed"] for one in cases.values()),
        "sentences": [line for result in found.values() for line in result.sentences()],
    }
    return Section(KEY, TITLE, MENU, command, context, data)


def _case(run: Material, case: Case) -> Json:
    references = run.references(case)
    families: dict[str, Json] = {}
    for name, meshes in run.families(case).items():
        limit = next(iter(meshes.values())).limit()
        errors, floors = {}, {}
        for reference in references:
            rows = [errors_of(run, case, meshes.get(s), reference) for s in run.plan.elements]
            errors[label(reference)] = [None if row is None else _kept(row) for row in rows]
            floor = errors_of(run, case, limit, reference)
            floors[label(reference)] = None if floor is None else _kept(floor)
        families[name] = {
            "records": [run.record(case, m) if (m := meshes.get(s)) is not None else None
                        for s in run.plan.elements],
            "labels": [label(m) if (m := meshes.get(s)) is not None else ""
                       for s in run.plan.elements],
            "errors": errors,
            "floors": floors,
            "limit": None if limit is None else label(limit),
        }  # fmt: skip
    return {
        "heading": case.heading,
        "families": families,
        "references": {label(one): _described(run, case, one) for one in references},
        "printed": [
            [s, mode, error]
            for (name, s, mode), error in published.figure3().items()
            if name == case.published
        ],
    }


def errors_of(
    run: Material, case: Case, model: Model | None, reference: Model
) -> NDArray[np.float64] | None:
    """Return 100 (f / f_reference - 1) [%] of the modes shown, paired by shape, or None."""
    ours = None if model is None else run.answers.get((case, model))
    against = run.answers.get((case, reference))
    count = max(run.plan.shown)
    if ours is None or against is None or len(against.frequencies) < count:
        return None
    first = ours.first(count)
    partner = pair(first, against, case.mechanism, case.pose).partner
    error = relative_error(first.frequencies, against.frequencies[partner])
    return np.asarray(error[[i - 1 for i in run.plan.shown]])


def _kept(values: NDArray[np.float64]) -> list[float | None]:
    return [digits(float(value), 8) for value in values]


def _described(run: Material, case: Case, reference: Model) -> dict[str, Any]:
    modes = run.answers[case, reference]
    own = modes.uncertainty
    shown = [i - 1 for i in run.plan.shown]
    percent = (
        None if own is None
        else [digits(100 * own[i] / modes.frequencies[i], 4) for i in shown]
    )  # fmt: skip
    return {
        "theory": modes.theory,
        "uncertainty": percent,
        "record": run.record(case, reference),
    }
