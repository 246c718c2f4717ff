"""The error budget: the parts that add up to the paper's one "error (%)"."""

import re
from collections.abc import Sequence

from harness.report.ledger import Ledger
from harness.report.results_table import cells, number
from harness.report.section import Cell, Section, digits
from harness.report.sources import Sources

COMMAND = "rps-bench budget"
MEANING = {
    "number of elements": "the theory with s elements less the same theory without any",
    "rotary inertia": "exact Euler-Bernoulli less exact Rayleigh",
    "shear": "exact Rayleigh less exact Timoshenko",
    "total error": "the sum of the parts: the paper's error (%)",
}


def section(sources: Sources, ledger: Ledger) -> Section:
    """Return the section."""
    table = sources.tables.get("budget")
    if table is None:
        missing = f"`{COMMAND} --references calculix-solid --output results` makes this section"
        return Section("budget", "Error budget", missing=missing)
    found = re.search(r"of (\S+)@s against (\S+),", table.title)
    theory, reference = (found[1], found[2]) if found else ("", "")
    steps = ",".join(dict.fromkeys(row[1] for row in table.rows if row[1]))
    command = f"{COMMAND} --model {theory} --references {reference} --elements {steps}"
    command = command if found else COMMAND

    def make(row: Sequence[str], k: int) -> str | Cell:
        if k < 3:
            return row[k]
        case, s, part = row[:3]
        own = "own GCI" in part
        parts = [ledger.model(case, reference)]
        parts += [] if own else [ledger.model(case, f"{theory}@{s}")]
        meaning = MEANING.get(part, f"{part}, in points of the reference's frequency")
        record = ledger.add(
            f"Error budget, {case}: {part}",
            {"What": meaning, "File": "results/budget.csv", "Command": command},
            parts,
        )
        what = f"{table.columns[k]}: {part}, s = {s or 'any'}, {case}"
        return number(row[k], ".3f" if own else "+.3f", "percentage points", what, record)

    rows = cells(table.rows, make)
    data = {
        "theory": theory,
        "reference": reference,
        "modes": table.columns[3:],
        "rows": [
            {"case": row[0], "s": row[1], "part": row[2],
             "values": [digits(_value(text), 8) for text in row[3:]],
             "records": [c.record if isinstance(c, Cell) else None for c in shown[3:]]}
            for row, shown in zip(table.rows, rows, strict=True)
        ],
    }  # fmt: skip
    context = {
        "table": table,
        "rows": rows,
        "cases": list(dict.fromkeys(row[0] for row in table.rows)),
        "elements": [s for s in dict.fromkeys(row[1] for row in table.rows) if s],
    }
    return Section("budget", "Error budget", context, data)


def _value(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
