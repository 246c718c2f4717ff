"""What `rps-bench check` runs: every model on a ladder of meshes, and a small workspace map."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import (
    STATIONS,
    InputError,
    Limits,
    Mechanism,
    Modes,
    Multipliers,
    Pose,
    condensed_frequencies,
    regular_workspace,
)
from harness.cases import PRESETS, Case
from harness.models import Model, Spec
from harness.run import GATE, Study, rows, run
from reference_models import catalogue

MODES = 6
THEORY_LADDER = (3, 4, 8, 16)
LADDERS = {
    "exudyn-cable": (4, 8, 16),
    "exudyn-beam": (6, 12, 24),
    "mujoco-cable": (4, 8, 16),
    "mujoco-chain": (6, 12, 24),
    "calculix-solid": (4, 6, 8),
    "ngsolve-solid": (1, 2, 4),
    "ngsolve-averaged": (1, 2, 4),
    "exudyn-ffrf": (1, 2),
}
"""Elements a limb. Two give no order; `exudyn-ffrf` at a third would take as long as all others."""
DEFAULT_LADDER = (4, 8, 16)  # of a simulator that somebody else added
SLOW = ("calculix-solid", "ngsolve-solid", "ngsolve-averaged", "exudyn-ffrf")
"""What `--quick` leaves out: solids, seconds a pose."""
MAP_MODELS = (
    Spec("timoshenko", None),
    Spec("euler-bernoulli", 3),
    Spec("exudyn-cable", 8),
    Spec("exudyn-beam", 12),
    Spec("mujoco-cable", 8),
)
LAYERS, AZIMUTHS, TILTS = (0.35, 0.49, 0.7), 12, 3  # [m]; azimuths hold every one's 120 deg turns
CONDENSED = (3, None)
"""Elements of the batch solver over the map: `condensed@3` and `condensed@exact`."""
YARDSTICK, REPEATS = "yardstick", 15
"""The model and case of the row that says how fast the machine was during the run."""


@dataclass(frozen=True)
class Formulation(Spec):
    """The paper's theory in the traditional formulation: `multipliers@S`, Euler-Bernoulli."""

    name: str = "multipliers"
    elements: int | tuple[int, int] | None = 3

    def build(self) -> Model:
        """Return the model."""
        assert isinstance(self.elements, int)
        return Multipliers(self.elements)


@dataclass(frozen=True)
class Plan:
    """What is solved: `ladders`, each one model on ascending meshes, and single `specs`, at
    `cases`; `mapped` at every pose of the workspace `poses`; `missing`: what cannot run here.
    """

    cases: tuple[Case, ...]
    ladders: tuple[tuple[Spec, ...], ...]
    specs: tuple[Spec, ...]
    mapped: tuple[Spec, ...]
    poses: tuple[Case, ...]
    missing: dict[str, str]
    condensed: bool = True

    @property
    def everywhere(self) -> tuple[Spec, ...]:
        """Every model that is solved at the cases."""
        return (*(spec for ladder in self.ladders for spec in ladder), *self.specs)

    @property
    def solves(self) -> int:
        """How many solutions that takes, for a progress bar."""
        return len(self.cases) * len(self.everywhere) + len(self.poses) * len(self.mapped)


@dataclass(frozen=True)
class Checked:
    """What a plan gave: modes at the `cases`, modes over the `workspace`, and tidy `rows`."""

    plan: Plan
    cases: Study
    workspace: Study
    rows: list[dict[str, Any]]


def standard(models: Sequence[str] | None = None, quick: bool = False) -> Plan:
    """Return the standard study: of `models` by name only, if given; `quick` without slow solids.

    A simulator that cannot run here is left out and named in `missing`. Raises `InputError` for a
    name that no model has.
    """
    theories = ("euler-bernoulli", "rayleigh", "timoshenko")
    info = dict(catalogue())
    names = [*theories, "multipliers", "condensed", *info]
    for name in models or ():
        if name not in names:
            raise InputError("--models", name, f"some of {', '.join(names)}")
    chosen = [name for name in names if name in (models or names) and not (quick and name in SLOW)]
    missing = {name: info[name].missing for name in chosen if name in info and info[name].missing}
    chosen = [name for name in chosen if name not in missing]
    meshes = dict.fromkeys(theories, THEORY_LADDER) | dict.fromkeys(info, DEFAULT_LADDER) | LADDERS
    ladders = tuple(tuple(Spec(name, n) for n in meshes[name]) for name in chosen if name in meshes)
    specs = tuple(Spec(name, None) for name in chosen if name in theories)
    if "multipliers" in chosen:
        specs += (Formulation(),)
    cases = (PRESETS["case1"], PRESETS["case2"])
    mapped = tuple(spec for spec in MAP_MODELS if spec.name in chosen)
    poses = workspace_cases(cases[0].mechanism)
    return Plan(cases, ladders, specs, mapped, poses, missing, "condensed" in chosen)


@cache
def workspace_cases(mechanism: Mechanism) -> tuple[Case, ...]:
    """Return the poses of the map: `LAYERS` x `AZIMUTHS` x `TILTS` from level to each rim."""
    grid = regular_workspace(mechanism, LAYERS, Limits()).grid(AZIMUTHS, TILTS)
    flat = [np.broadcast_to(x, grid.shape).ravel() for x in (grid.z, grid.azimuth, grid.tilt)]
    return tuple(
        Case(f"{GATE}-{i}", mechanism, pose, "regular workspace")
        for i, pose in enumerate(Pose(*flat))
    )


def solve(plan: Plan, done: Callable[[str], None] = lambda _: None) -> Checked:
    """Solve everything in the plan, with the yardstick before, between and after."""
    machine = [yardstick()]
    cases = run(plan.cases, plan.everywhere, MODES, done)
    machine.append(yardstick())
    workspace = run(plan.poses, plan.mapped, MODES, done)
    machine.append(yardstick())
    found = rows(cases) + [row | {"case": GATE} for row in rows(workspace)]
    if plan.condensed:
        found += _condensed(plan)
    found.append(_yardstick_row(machine))
    return Checked(plan, cases, workspace, found)


def _condensed(plan: Plan) -> list[dict[str, Any]]:
    """Return the rows of the batch solver over the map; `solve_s` is its time a pose."""
    poses = Pose(*(np.array([getattr(c.pose, x) for c in plan.poses]) for x in Pose.__match_args__))
    mechanism = plan.poses[0].mechanism
    n = len(mechanism.limbs)
    found = []
    for elements in CONDENSED:
        condensed_frequencies(mechanism, poses[:2], elements, count=MODES)  # tables load once
        began = time.perf_counter()
        table = condensed_frequencies(mechanism, poses, elements, count=MODES)
        seconds = (time.perf_counter() - began) / len(plan.poses)
        batch = Modes(
            frequencies=table[0],
            platform=np.zeros((MODES, 6)),  # frequencies alone: there are no shapes
            limbs=np.zeros((MODES, n, len(STATIONS), 3)),
            theory="Euler-Bernoulli",
            model="condensed",
            version="rps-bench, condensed",
            elements=elements,
            dofs=6 if elements is None else 6 + n * (6 * elements - 2),
            residual=None,
            build_seconds=0.0,
            solve_seconds=seconds,
        )
        spec = Spec("condensed", elements)
        modes = {
            (case.name, spec.label): replace(batch, frequencies=frequencies)
            for case, frequencies in zip(plan.poses, table, strict=True)
        }
        found += [
            row | {"case": GATE} for row in rows(Study(plan.poses, (spec,), MODES, modes, {}))
        ]
    return found


def yardstick_matrix(masses: int = 150) -> NDArray[np.float64]:
    """Return K of unit masses in a row between walls, unit springs between, (masses, masses).

    omega_k = 2 sin(k pi / 2 (masses + 1)).
    """
    return np.asarray(2 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1))


def yardstick() -> tuple[float, float]:
    """Return the chain's lowest frequency [Hz] and the median time of its eigen-solution [s]."""
    K, seconds = yardstick_matrix(), []
    for _ in range(REPEATS):
        began = time.perf_counter()
        values = np.linalg.eigh(K)[0]
        seconds.append(time.perf_counter() - began)
    return float(np.sqrt(values[0]) / (2 * np.pi)), median(seconds)


def _yardstick_row(measured: Sequence[tuple[float, float]]) -> dict[str, Any]:
    return {
        "case": YARDSTICK,
        "model": YARDSTICK,
        "theory": "springs and masses in a row",
        "version": f"numpy {np.__version__}",
        "mode": 1,
        "frequency_hz": measured[0][0],
        "build_s": 0.0,
        "solve_s": median(seconds for _, seconds in measured),
    }
