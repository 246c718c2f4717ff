"""Runs models at cases; one failure costs its own result only."""

import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256
from typing import Any

from analytic import Mechanism, Modes
from analytic.pairing import Pairing, pair
from harness.cases import Case
from harness.models import Spec, takes_shear
from reference_models import ModelError, names

SPARE = 2
"""Modes solved for beyond those asked for, so that a mode that changes places is still found."""


MANY_POSES = GATE, MAP, SWEEP = "workspace", "map", "sweep"
"""What `case` says in the history of poses without a name: of `check`, of `workspace` and `claims`,
of `sweep`."""

_kept: ContextVar[dict[Any, Modes] | None] = ContextVar("kept", default=None)


@contextmanager
def keeping() -> Iterator[None]:
    """Keep every answer while this lasts: no model solves the same case twice."""
    token = _kept.set({})
    try:
        yield
    finally:
        _kept.reset(token)


@dataclass(frozen=True)
class Study:
    """Modes of every model at every case, by (case name, model label); failures in words."""

    cases: tuple[Case, ...]
    specs: tuple[Spec, ...]
    count: int
    modes: dict[tuple[str, str], Modes]
    failures: dict[tuple[str, str], str]

    def get(self, case: Case, spec: Spec) -> Modes | None:
        """Return the modes, or None where the model failed."""
        return self.modes.get((case.name, spec.label))

    def pairing(self, case: Case, theory: Spec, reference: Spec) -> Pairing | None:
        """Return the partner in `reference` of each of the first `count` modes of `theory`."""
        first, second = self.get(case, theory), self.get(case, reference)
        if first is None or second is None:
            return None
        return pair(first.first(self.count), second, case.mechanism, case.pose)


def run(
    cases: Iterable[Case],
    specs: Iterable[Spec],
    count: int,
    done: Callable[[str], None] = lambda _: None,
) -> Study:
    """Solve every case by every model; `done` hears of each. Raises for a pose out of reach."""
    cases, specs = tuple(cases), tuple(dict.fromkeys(specs))
    modes, failures = {}, {}
    kept = _kept.get()
    known = {} if kept is None else kept
    for spec in specs:
        model = spec.build()
        for case in cases:
            key = (case.name, spec.label)
            asked = (spec, case.mechanism, case.pose, count)
            try:
                if asked not in known:
                    known[asked] = model.modes(case.mechanism, case.pose, count + SPARE)
                modes[key] = known[asked]
            except ModelError as error:
                failures[key] = str(error)
            done(f"{spec.label} at {case.name}")
    return Study(cases, specs, count, modes, failures)


def rows(study: Study) -> list[dict[str, Any]]:
    """Return one tidy row a case, model and mode, each with its provenance; SI units.

    `assurance` is that of each mode with its partner in the case's first model with an answer; None
    for that model itself.
    """
    result = []
    chosen = {spec: settings(spec, study.count + SPARE) for spec in study.specs}
    for case in study.cases:
        answered = [spec for spec in study.specs if study.get(case, spec) is not None]
        for spec in answered:
            modes = study.modes[case.name, spec.label]
            found = mode_rows(case, spec, chosen[spec], modes, study.count)
            pairing = study.pairing(case, spec, answered[0]) if spec != answered[0] else None
            if pairing is not None:
                for row, assurance in zip(found, pairing.assurance.tolist(), strict=True):
                    row["assurance"] = assurance
            result += found
    return result


def mode_rows(
    case: Case, spec: Spec, settings: str, modes: Modes, count: int
) -> list[dict[str, Any]]:
    """Return one tidy row for each of the first `count` modes of `spec` at a case; SI units."""
    uncertainty = modes.uncertainty
    return [
        {
            "case": case.name,
            "mechanism": mechanism_hash(case.mechanism),
            "z_m": case.pose.z,
            "azimuth_rad": case.pose.azimuth,
            "tilt_rad": case.pose.tilt,
            "model": spec.label,
            "theory": modes.theory,
            "settings": settings,
            "version": modes.version,
            "mode": i + 1,
            "frequency_hz": float(modes.frequencies[i]),
            "uncertainty_hz": None if uncertainty is None else float(uncertainty[i]),
            "assurance": None,
            "closure_m": modes.residual,
            "dofs": modes.dofs,
            "build_s": modes.build_seconds,
            "solve_s": modes.solve_seconds,
        }
        for i in range(count)
    ]


@lru_cache(maxsize=64)
def mechanism_hash(mechanism: Mechanism) -> str:
    """Return what names a mechanism's parameters, all of them, in twelve digits."""
    return sha256(repr(mechanism).encode()).hexdigest()[:12]


def settings(spec: Spec, count: int, **how: Any) -> str:
    """Return as JSON what a model's label leaves out: the modes solved for, its kappa if any.

    `how`: what else tells a way of solving it from others.
    """
    chosen: dict[str, Any] = {"count": count}
    simulated = not spec.analytic and spec.name in names()  # which looks at what is installed
    if spec.name == "timoshenko" or (simulated and takes_shear(spec.name)):
        chosen["shear"] = spec.shear
    return json.dumps(chosen | how)
