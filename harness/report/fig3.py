"""Fig. 3: error against the number of elements, for any theory against any reference."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import Modes
from analytic.pairing import REPEATED, pair, repeated
from analytic.theory import BEAMS
from harness import published
from harness.cases import Case
from harness.models import Spec
from harness.report.ledger import Ledger
from harness.report.section import Section, digits
from harness.report.sources import ELEMENTS, Sources
from harness.run import Study

COUNT = 6
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Reference:
    """What the theories are held against at one case.

    Attributes: `label`; `theory` it stands for; `frequencies` (6,) and their `uncertainty` (6,)
    or None [Hz]; `twin`, the exact theory whose modes are its modes, one by one; `record`.
    """

    label: str
    theory: str
    frequencies: Floats
    uncertainty: Floats | None
    twin: str
    record: int | None


def section(sources: Sources, ledger: Ledger) -> Section:
    """Return the section."""
    cases: dict[str, dict[str, Any]] = {}
    notes: list[str] = []
    for case in sources.study.cases:
        references, unpaired = _references(sources, ledger, case)
        notes += unpaired
        theories: dict[str, dict[str, Any]] = {}
        for beam in BEAMS:
            errors: dict[str, list[Any]] = {one.label: [] for one in references}
            for s in ELEMENTS:
                modes, partners = _partners(sources.study, case, Spec(beam, s))
                for one in references:
                    errors[one.label].append(_errors(modes, partners[one.twin], one))
            records = [ledger.solved(sources.study, case, Spec(beam, s)) for s in ELEMENTS]
            theories[beam] = {"records": records, "errors": errors}
        cases[case.name] = {
            "theories": theories,
            "references": {one.label: _described(one) for one in references},
            "printed": [
                [s, mode, error]
                for (name, s, mode), error in published.figure3().items()
                if name == case.published
            ],
        }
    every = list(dict.fromkeys(name for one in cases.values() for name in one["references"]))
    data = {"elements": ELEMENTS, "cases": cases}
    context = {
        "cases": list(cases),
        "theories": BEAMS,
        "references": every,
        "chosen": next((name for name in every if name.startswith("exudyn-beam")), every[0]),
        "notes": notes,
    }
    return Section("fig3", "Fig. 3: error against the number of elements", context, data)


def _described(one: Reference) -> dict[str, Any]:
    own = one.uncertainty
    percent = None if own is None else [digits(100 * u, 4) for u in own / one.frequencies]
    return {"theory": one.theory, "uncertainty": percent, "record": one.record}


def _references(sources: Sources, ledger: Ledger, case: Case) -> tuple[list[Reference], list[str]]:
    """Return the accepted run's models, then the exact theories; and who cannot be paired."""
    exact = []
    limits = {beam: sources.study.modes[case.name, Spec(beam, None).label] for beam in BEAMS}
    for beam, modes in limits.items():
        record = ledger.solved(sources.study, case, Spec(beam, None))
        f = modes.frequencies[:COUNT]
        exact.append(Reference(Spec(beam, None).label, modes.theory, f, None, beam, record))
    found, notes = [], []
    frame = sources.frequencies
    rows = [] if frame.is_empty() else frame.filter(case=case.name).sort("mode").to_dicts()
    for label in dict.fromkeys(row["model"] for row in rows):
        own = [row for row in rows if row["model"] == label][:COUNT]
        if label.partition("@")[0] in BEAMS or len(own) < COUNT:
            continue
        f = np.array([row["frequency_hz"] for row in own])
        twin = nearest(f, {beam: modes.frequencies for beam, modes in limits.items()})
        if twin is None:
            notes.append(f"{label} at {case.name}: too far from every exact theory to tell which "
                         "mode is which by frequency alone; `rps-bench convergence` pairs it by "
                         "shape")  # fmt: skip
            continue
        given = [row["uncertainty_hz"] for row in own]
        uncertainty = None if None in given else np.array(given, dtype=float)
        record = ledger.model(case.name, label)
        found.append(Reference(label, own[0]["theory"], f, uncertainty, twin, record))
    return [*found, *exact], notes


def nearest(f: Floats, exact: Mapping[str, Floats]) -> str | None:
    """Return the exact theory whose modes have frequencies `f` (6,), or None where it is not plain.

    The shapes of a simulator are not kept. Its i-th frequency is that of the i-th exact mode if it
    lies nearer to it than a third of the way to the next distinct one.
    """
    best = min(exact, key=lambda beam: float(np.abs(exact[beam][: len(f)] / f - 1).max()))
    own = exact[best]
    for group in repeated(own, REPEATED):
        others = np.delete(own, group)
        for i in range(group.start, min(group.stop, len(f))):
            if abs(f[i] - own[i]) > np.abs(others - own[i]).min(initial=np.inf) / 3:
                return None
    return best


def _partners(study: Study, case: Case, spec: Spec) -> tuple[Modes, dict[str, NDArray[np.intp]]]:
    """Return the modes of `spec`, and which mode each is, by shape, in every exact theory."""
    modes = study.modes[case.name, spec.label].first(COUNT)
    exact = {beam: study.modes[case.name, Spec(beam, None).label] for beam in BEAMS}
    pairs = {beam: pair(modes, limit, case.mechanism, case.pose) for beam, limit in exact.items()}
    return modes, {beam: pairing.partner for beam, pairing in pairs.items()}


def _errors(modes: Modes, partner: NDArray[np.intp], one: Reference) -> list[float | None]:
    """Return 100 (f / f_reference - 1) [%] of each mode."""
    return [
        digits(100 * (float(f) / float(one.frequencies[k]) - 1), 8) if k < COUNT else None
        for f, k in zip(modes.frequencies, partner, strict=True)
    ]
