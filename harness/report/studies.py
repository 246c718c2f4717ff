"""Sections of studies that say it in tables: claims, budget, work and precision, and the others."""

from dataclasses import replace

from harness.bench import label
from harness.report.ledger import answer
from harness.report.material import Material
from harness.report.section import Json, Section, digits, number, shown
from harness.rows import mode_rows
from harness.studies.budget import ELEMENTS, Budget
from harness.studies.claims import verb
from harness.studies.precision import GROUPS, Point, WorkPrecision

VERDICTS = ("fails", "cannot be reproduced", "holds only if", "holds", "other")
"""Kinds of verdicts as they begin, what a reader looks for first; the last one is of no kind."""
CLAIM = {
    "Where": "section", "Printed": "quoted", "Checked": "how", "Measured": "measured",
    "Uncertainty": "uncertainty", "Verdict": "verdict", "Command": "command",
}  # fmt: skip
"""What is said of a claim, and its column in the study of claims."""
MEANING = {
    ELEMENTS: "the theory with s elements less the same theory without any",
    "rotary inertia": "exact Euler-Bernoulli less exact Rayleigh",
    "shear": "exact Rayleigh less exact Timoshenko",
}
OTHERS = {
    "refine": "Limits", "slenderness": "Slenderness", "stiffness": "Stiffness", "cost": "Cost",
    "identify": "Identification",
}  # fmt: skip
"""Studies without a picture of their own, and what the navigation calls them."""


def verdicts(run: Material) -> list[Json]:
    """Return the claims of the run: columns of `CLAIM` and the id, and the `kind` of verdict."""
    part = run.part("claims")
    claims = []
    for result in part.results.values() if part else ():
        for row in result.to_frame().to_dict("records"):
            claim = {n: t if isinstance(t := row.get(n), str) else "" for n in CLAIM.values()}
            kinds = (kind for kind in VERDICTS if claim["verdict"].lower().startswith(kind))
            claims.append({"id": row["id"], **claim, "kind": next(kinds, VERDICTS[-1])})
    return claims


def claims(run: Material) -> Section | None:
    """Return the paper's claims and their verdicts, as the study of claims judged them."""
    found = verdicts(run)
    if not found:
        return None
    for claim in found:
        fields = {heading: claim[name] for heading, name in CLAIM.items()}
        claim["record"] = run.ledger.add(f"Claim {claim['id']}", fields, [run.run])
        claim["verdict"], _, claim["why"] = claim["verdict"].partition(": ")
    kinds = {kind: [one for one in found if one["kind"] == kind] for kind in VERDICTS}
    groups = [[kind, own, verb(kind, len(own))] for kind, own in kinds.items() if own]
    context = {"count": len(found), "groups": groups}
    title = "The paper's claims, one by one"
    return Section("claims", title, "Claims", run.only("claims"), context)


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
    return Section("budget", "Error budget", "Budget", run.only("budget"), context, data)


def _budget(run: Material, one: Budget) -> Json:
    pick = [i - 1 for i in one.shown]
    cases = {}
    for case, shares in one.shares.items():
        records = []
        for s in one.elements:
            mesh = replace(one.theory, elements=s)
            parts = [run.record(case, model) for model in (mesh, one.reference)]
            where = f"s = {s}, against {label(one.reference)}"
            records.append([
                run.ledger.add(
                    f"Error budget, {case.name}: {part}, {where}",
                    {"What": MEANING.get(part, "in points of the reference's frequency"),
                     "Command": run.only("budget")}, parts,
                )
                for part in (*one.parts, "total error")
            ])  # fmt: skip
        cases[case.name] = {
            "shares": digits(shares[:, :, pick], 8),
            "total": digits(shares.sum(axis=1)[:, pick], 8),
            "band": digits(one.band(case, one.reference)[pick], 4),
            "records": records,
        }
    return {
        "theory": one.theory.name,
        "reference": label(one.reference),
        "parts": list(one.parts),
        "elements": list(one.elements),
        "modes": list(one.shown),
        "cases": cases,
    }


def work(run: Material) -> Section | None:
    """Return what an accuracy costs, model by model."""
    found = next(iter(run.of(WorkPrecision)), None)
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
    title = "Work and precision"
    return Section("work-precision", title, "Precision", run.only("work-precision"), context, data)


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
        "method": point.method,
        "size": point.size,
        "theory": info.theory,
        "many": point.poses > 1,
        "ms": digits(1e3 * point.seconds, 4),
        "errors": digits(worst, 5),
        "record": run.ledger.add(f"{point.method}, elements {point.size}", fields, [run.run]),
    }


def other(run: Material, name: str) -> Section | None:
    """Return what the study called `name`, one of `OTHERS`, says, and its tables."""
    part = run.part(name)
    if part is None:
        return None
    about = name, part.entry.title, OTHERS[name], run.only(name)
    if not part.results:
        return Section(*about, missing=f"not made: {part.why}")
    record = run.ledger.add(part.entry.title, {"Command": run.only(name)}, [run.run])
    tables = [one for result in part.results.values() for one in result.tables().values()]
    context = {"sentences": part.sentences(), "tables": [shown(one, record) for one in tables]}
    return Section(*about, context)


def provenance(run: Material) -> Section | None:
    """Return every model with an answer: its version, size, joint gap and cost."""
    left = {what: why for one in run.results for what, why in one.failures().items()}
    left |= {part.entry.title: part.why for part in run.parts if part.why}
    if not run.answers and not left:
        return None
    rows = []
    for case in run.plan.cases:
        for model in run.models(case):
            modes = run.answers[case, model]
            said = answer(mode_rows(case, label(model), "", modes, 1))
            own = modes.uncertainty
            percent = "" if own is None else f"{100 * own[0] / modes.frequencies[0]:.2g}"
            what = f"{label(model)} at {case.name}"
            rows.append([
                case.name, number(label(model), "", what, run.record(case, model)),
                said["Theory"], said["Version"], said["Coordinates"], said["Joint gap"], percent,
                said["Time"],
            ])  # fmt: skip
    table = {
        "title": "Every model of the run; uncertainty is the numerical one, by extrapolation",
        "columns": ["Case", "Model", "Theory", "Version", "Coordinates", "Joint gap",
                    "Uncertainty of f1 [%]", "Time"],
        "numeric": [False, False, False, False, True, True, True, False],
        "rows": rows,
        "notes": [],
    }  # fmt: skip
    context = {"table": table, "failures": [f"{what}: {why}" for what, why in left.items()]}
    title = "Provenance: where the numbers come from"
    return Section("provenance", title, "Provenance", run.command, context)
