"""Work and precision: what an accuracy costs, model by model."""

import math

from harness.report.material import Material
from harness.report.section import Json, Section, digits, shown
from harness.studies.precision import GROUPS, Point, WorkPrecision

KEY, TITLE, MENU = "work-precision", "Work and precision", "Work and precision"


def section(run: Material) -> Section | None:
    """Return the section."""
    found = next(iter(run.of(WorkPrecision).values()), None)
    if found is None:
        return None
    rows = [_point(run, found, point) for point in found.points]
    kinds = list(found.kinds.items())
    data = {"rows": rows, "kinds": [against for _, against in kinds], "groups": list(GROUPS)}
    context = {
        "theories": list(dict.fromkeys(row["theory"] for row in rows)),
        "kinds": [[str(k), against] for k, (_, against) in enumerate(kinds)],
        "groups": [[str(k), group] for k, group in enumerate(GROUPS)],
        "sentences": found.sentences(),
        "tables": [shown(table, lambda row, k: None) for table in found.tables().values()],
        "cases": ", ".join(case.name for case in found.cases),
    }
    return Section(KEY, TITLE, MENU, run.only("work-precision"), context, data)


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
    return {
        "method": point.method,
        "size": point.size,
        "theory": info.theory,
        "many": point.poses > 1,
        "ms": digits(1e3 * point.seconds, 4),
        "errors": [
            [_known(point.worst(kind, modes)) for modes in GROUPS.values()] for kind in found.kinds
        ],
        "record": run.ledger.add(f"{point.method}, elements {point.size}", fields, [run.run]),
    }


def _known(error: float) -> float | None:
    return digits(error, 5) if math.isfinite(error) else None
