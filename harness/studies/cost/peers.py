"""The same frames by another finite element package, beside ours and the plain floor."""

from dataclasses import dataclass, replace
from functools import partial
from timeit import timeit

import numpy as np
import scipy

from analytic import InputError, Substructure
from harness.case import Case
from harness.compare import cells
from harness.presets import PAPER_ELEMENTS
from harness.tables import Cell, Number, Table
from harness.timing import SHIFT
from reference_models import ModelError, UnavailableError, peers
from reference_models.peers import Peer

SIZES = (PAPER_ELEMENTS, 8)


@dataclass(frozen=True)
class Peers:
    """What `found` others and ours took, one of `ours` a size; `reason` why others are missing."""

    found: tuple[Peer, ...]
    ours: tuple[Peer, ...]
    reason: str


def measured(case: Case, count: int, rounds: int) -> Peers:
    """Return what frames of `SIZES` take at a case, with `scipy.linalg.eigh` in every round."""
    found, ours, reason = list[Peer](), list[Peer](), ""
    pair = [A.toarray() for A in Substructure(PAPER_ELEMENTS).matrices(case.mechanism, case.pose)]
    for s in SIZES:
        model, times = Substructure(s), []
        for k in range(rounds + 1):
            pose = replace(case.pose, z=case.pose.z + SHIFT * k)
            modes = model.modes(case.mechanism, pose, count)
            spent = timeit(partial(scipy.linalg.eigh, *pair), number=1)
            times.append((modes.build_seconds, modes.solve_seconds, spent))
        ours.append(Peer("ours", s, modes.frequencies, *np.array(times[1:]).T))
        try:
            found += peers.timed(case.mechanism, case.pose, s, count, rounds, (pair[0], pair[1]))
        except (InputError, UnavailableError, ModelError) as error:
            reason = str(error)
    return Peers(tuple(found), tuple(ours), reason)


def peers_table(result: Peers) -> Table:
    """Return seconds and frequencies of all, those of ours beside."""
    rows: list[tuple[Cell, ...]] = []
    for own in result.ours:
        for one in (own, *(p for p in result.found if p.elements == own.elements)):
            whole = one.build + one.solve
            apart = float(np.abs(one.frequencies / own.frequencies - 1).max())
            rows.append((
                one.name, one.elements,
                *cells(1e3 * np.median([one.build, one.solve, whole], axis=1), 3),
                Number(float(np.median(whole / one.eigh)), 2), f"{apart:.0e}",
            ))  # fmt: skip
        floor = cells([1e3 * np.median(own.eigh)] * 2, 3)
        rows.append(("the floor: scipy.linalg.eigh", PAPER_ELEMENTS, "-", *floor, Number(1.0, 2),
                     "-"))  # fmt: skip
    columns = ("Frame", "s", "build [ms]", "solve [ms]", "both [ms]", "eigh = 1", "apart")
    notes = [
        f"eigh: of the s = {PAPER_ELEMENTS} pair, in the same process and round; shapes are not "
        "read; apart: largest relative difference of f1-f6 from ours",
        *([f"not measured: {result.reason}"] if result.reason else []),
    ]
    return Table("The same frames by other programs", columns, tuple(rows), tuple(notes))
