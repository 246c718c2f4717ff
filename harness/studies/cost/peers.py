"""The same frames by another finite element package, beside ours and the plain floor."""

import time
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from analytic import InputError, Substructure
from harness.case import Case
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
    found: list[Peer] = []
    ours, reason = [], ""
    K, M = Substructure(PAPER_ELEMENTS).matrices(case.mechanism, case.pose)
    pair = K.toarray(), M.toarray()
    for s in SIZES:
        model, built, solved, eigh = Substructure(s), [], [], []
        for k in range(rounds + 1):
            pose = replace(case.pose, z=case.pose.z + SHIFT * k)
            modes = model.modes(case.mechanism, pose, count)
            built.append(modes.build_seconds)
            solved.append(modes.solve_seconds)
            began = time.perf_counter()
            scipy.linalg.eigh(*pair)
            eigh.append(time.perf_counter() - began)
        times = (np.array(seconds[1:]) for seconds in (built, solved, eigh))
        ours.append(Peer("ours", s, modes.frequencies, *times))
        try:
            found += peers.timed(case.mechanism, case.pose, s, count, rounds, pair)
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
                one.name, one.elements, *(_ms(x) for x in (one.build, one.solve, whole)),
                Number(float(np.median(whole / one.eigh)), 2), f"{apart:.0e}",
            ))  # fmt: skip
        rows.append(("the floor: scipy.linalg.eigh", PAPER_ELEMENTS, "-", *[_ms(own.eigh)] * 2,
                     Number(1.0, 2), "-"))  # fmt: skip
    columns = ("Frame", "s", "build [ms]", "solve [ms]", "both [ms]", "eigh = 1", "apart")
    notes = [
        f"eigh: of the s = {PAPER_ELEMENTS} pair, in the same process and round; shapes are not "
        "read; apart: largest relative difference of f1-f6 from ours",
        *([f"not measured: {result.reason}"] if result.reason else []),
    ]
    return Table("The same frames by other programs", columns, tuple(rows), tuple(notes))


def _ms(seconds: NDArray[np.float64]) -> Number:
    return Number(1e3 * float(np.median(seconds)), 3)
