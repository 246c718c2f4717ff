"""Table I, and every claim of the paper with its verdict."""

import re
from collections.abc import Sequence

from harness.report.ledger import Ledger
from harness.report.results_table import Row, cells, number
from harness.report.section import Cell, Section
from harness.report.sources import Sources, TableFile
from harness.report.status import VERDICTS, kind

COMMAND = "rps-bench reproduce"


def section(sources: Sources, ledger: Ledger) -> Section:
    """Return the section."""
    table = sources.tables.get("table1")
    claims = [
        {**claim, "kind": kind(claim.get("verdict", "")), "record": _record(claim, ledger)}
        for claim in sources.claims
    ]
    found = {claim["kind"] for claim in claims}
    context = {
        "table": table,
        "rows": table_rows(table, ledger) if table else [],
        "claims": claims,
        "kinds": [one for one in (*VERDICTS, "other") if one in found],
    }
    missing = "" if table or claims else f"`{COMMAND}` and `rps-bench claims` make this section"
    return Section("claims", "Table I and the claims", context, missing=missing)


def _record(claim: dict[str, str], ledger: Ledger) -> int:
    fields = {
        "Where": claim.get("section", ""),
        "Printed": claim.get("quoted", ""),
        "Checked": claim.get("how", ""),
        "Measured": claim.get("measured", ""),
        "Uncertainty": claim.get("uncertainty", ""),
        "Verdict": claim.get("verdict", ""),
        "Command": claim.get("command", ""),
    }
    return ledger.add(f"Claim {claim.get('id', '')}", fields)


def table_rows(table: TableFile, ledger: Ledger) -> list[Row]:
    """Return Table I; each number with the models behind it: those named last above it."""
    fea = theory = ""
    records = {}
    for row in table.rows:
        case, method = row[:2]
        label = re.search(r"\((.*@.*)\)", method)
        if label and method.startswith("FEA"):
            fea = label[1]
        elif label and method.startswith("Theoretical"):
            theory = label[1]
        records[row] = _behind(case, method, fea, theory, ledger)

    def make(row: Sequence[str], k: int) -> str | Cell:
        if k < 2:
            return row[k]
        percent = "%" in row[1]
        form = ".4f" if "uncertainty" in row[1] else "+.2f" if percent else ".3f"
        if row[1].startswith("printed"):
            form = ".2f"
        what = f"{table.columns[k].split()[0]}: {row[1]}, {row[0]}"
        return number(row[k], form, "%" if percent else "Hz", what, records[tuple(row)])

    return cells(table.rows, make)


def _behind(case: str, method: str, fea: str, theory: str, ledger: Ledger) -> int | None:
    """Return the record of one row of Table I."""
    ours, theirs = ledger.model(case, theory), ledger.model(case, fea)
    title = f"{method}, {case}"
    if method.startswith("printed"):
        fields = {"File": "results/published/table1.csv", "Where": "Table I of the paper"}
        return ledger.add(title, fields)
    if method.startswith("Theoretical"):
        return ours
    if "against printed" in method:
        formula = "100 (theoretical / printed theoretical - 1)"
        return ledger.add(title, {"Made as": formula, "Command": COMMAND}, [ours])
    if method.startswith("Error"):
        formula = "100 (theoretical / FEA - 1), modes paired by shape"
        return ledger.add(title, {"Made as": formula, "Command": COMMAND}, [ours, theirs])
    if "uncertainty" in method:
        formula = "100 (uncertainty / frequency): numerical error estimated by extrapolation"
        return ledger.add(title, {"Made as": formula, "Command": COMMAND}, [theirs])
    return theirs
