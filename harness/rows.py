"""Tidy rows: what the history keeps of an answer, with where it comes from; SI units."""

import json
from functools import lru_cache
from hashlib import sha256
from typing import Any

from analytic import Mechanism, Modes
from analytic.model import Model
from harness.case import Case
from harness.poses import columns

MANY_POSES = GATE, MAP, PLANE, SWEEP = "workspace", "map", "plane", "sweep"
"""What `case` says in the history of poses without a name: of `check`, of `workspace` and `claims`,
of `workspace --plane`, of `sweep`."""


def mode_rows(
    case: Case, model: str, settings: str, modes: Modes, count: int
) -> list[dict[str, Any]]:
    """Return one tidy row for each of the first `count` modes of a model at a case."""
    uncertainty = modes.uncertainty
    return [
        {
            "case": case.name,
            "mechanism": mechanism_hash(case.mechanism),
            **columns(case.pose),
            "model": model,
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


def settings(model: Model, count: int, **how: Any) -> str:
    """Return as JSON what a row's other columns leave out: modes solved for, the model's settings.

    `how`: what else tells a way of solving it from others.
    """
    return json.dumps({"count": count} | dict(getattr(model, "settings", ())) | how)
