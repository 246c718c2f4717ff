"""Fig. 3: error against the number of elements, with the floor that no number removes."""

from analytic.model import Model
from harness.bench import label
from harness.case import Case
from harness.compare import at, match
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
    data = {
        "elements": list(run.plan.elements),
        "modes": list(run.plan.shown),
        "cases": cases,
        "command": command,
    }
    context = {"sentences": [line for result in found for line in result.sentences()]}
    return Section(KEY, TITLE, MENU, command, context, data)


def _case(run: Material, case: Case) -> Json:
    references = run.references(case)
    families = {}
    for name, meshes in run.families(case).items():
        limit = next(iter(meshes.values())).limit()
        models = [meshes.get(s) for s in run.plan.elements]
        families[name] = {
            "records": [run.record(case, model) for model in models],
            "labels": [label(model) if model else "" for model in models],
            "errors": {
                label(one): [_errors(run, case, model, one) for model in models]
                for one in references
            },
            "floors": {label(one): _errors(run, case, limit, one) for one in references},
            "limit": label(limit) if limit else None,
        }
    return {
        "heading": case.heading,
        "families": families,
        "references": {label(one): _described(run, case, one) for one in references},
        "printed": [
            [s, mode, error]
            for (name, s, mode), error in (case.paper.errors.items() if case.paper else ())
            if name == case.published
        ],
    }


def _errors(
    run: Material, case: Case, model: Model | None, reference: Model
) -> list[float | None] | None:
    """Return 100 (f / f_reference - 1) [%] of the modes shown, paired by shape, or None."""
    short = len(run.answers[case, reference].frequencies) < run.plan.count
    found = None if short or model is None else match(run.study, case, model, reference)
    return None if found is None else digits(at(found.error, run.plan.shown), 8)


def _described(run: Material, case: Case, reference: Model) -> Json:
    modes = run.answers[case, reference]
    own = None if modes.uncertainty is None else 100 * modes.uncertainty / modes.frequencies
    return {
        "theory": modes.theory,
        "uncertainty": None if own is None else digits([own[i - 1] for i in run.plan.shown], 4),
        "record": run.record(case, reference),
    }
