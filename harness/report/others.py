"""Studies without a picture of their own on the page: what they say, and their tables."""

from harness.report.material import Material
from harness.report.section import Section, shown

MENU = {
    "refine": "Order and limit", "slenderness": "Slenderness", "cost": "Cost",
    "identify": "Identification",
}  # fmt: skip
"""Studies that are shown so, and what the navigation calls them."""


def section(run: Material, name: str) -> Section | None:
    """Return the section of the study called `name`."""
    part = run.part(name)
    if part is None:
        return None
    if not part.results:
        return Section(name, part.entry.title, MENU[name], run.only(name),
                       missing=f"not made: {part.why}")  # fmt: skip
    record = run.ledger.add(part.entry.title, {"Command": run.only(name)}, [run.run])
    tables = [
        shown(table, lambda row, k: record)
        for result in part.results.values()
        for table in result.tables().values()
    ]
    context = {"sentences": part.sentences(), "tables": tables}
    return Section(name, part.entry.title, MENU[name], run.only(name), context)
