"""What a check runs: every model of the catalogue on its ladder of meshes, and a small map.

Beside it a yardstick says how fast the machine is: an eigen-solution of known answer, timed.
"""

import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import chain
from statistics import median
from typing import Any

import numpy as np

from analytic import InputError, Limits, Mechanism, Pose, regular_workspace
from analytic.model import Model
from harness.answer import Batch, BatchTask
from harness.bench import Bench, Study, label
from harness.case import Case
from harness.presets import GATE_MAP, GATE_MORE
from harness.rows import GATE
from harness.workers import Failure, attempt
from reference_models import Named, catalogue

MODES = 6
LAYERS, HEIGHT = (0.35, 0.49, 0.7), 0.49
"""Heights of the map [m] where the first case is at `HEIGHT`; in proportion elsewhere."""
AROUND, TILTS = 4, 3
"""Azimuths of the map for each limb, so that every one's turns by a limb are among them; tilts."""
LEAST = 0.01
"""Tilt of a map's rim [rad] below which there is nothing to map."""
NOT_ASKED = "not asked for"
PLACE = f"{GATE} z="
"""What the name of a pose of the map begins with; its coordinates follow."""
YARDSTICK, REPEATS = "yardstick", 15
"""The model and case of the row that says how fast the machine was."""


@dataclass(frozen=True)
class Plan:
    """What is solved.

    Attributes: `ladders`, each one model on ascending meshes, and `singles`, at `cases`; `mapped`
    at every pose of the workspace `poses`; `skipped`, by name, models that are left out and why;
    `notes` in words; `asked` for by name: of these none may be left out.
    """

    cases: tuple[Case, ...]
    ladders: tuple[tuple[Named, ...], ...]
    singles: tuple[Named, ...]
    mapped: tuple[Named, ...]
    poses: tuple[Case, ...]
    skipped: Mapping[str, str]
    notes: tuple[str, ...] = ()
    asked: frozenset[str] = frozenset()

    @property
    def everywhere(self) -> tuple[Named, ...]:
        """Every model that is solved at the cases."""
        return tuple(dict.fromkeys(chain(*self.ladders, self.singles)))


@dataclass(frozen=True)
class Checked:
    """What a plan gave on a `bench`: modes at the `cases` and over the `workspace`.

    `batches`: of models that take many poses a call; `rows`: tidy, for the history.
    """

    plan: Plan
    bench: Bench
    cases: Study
    workspace: Study
    batches: Mapping[Model, Batch | Failure]
    rows: list[dict[str, Any]]

    @property
    def studies(self) -> tuple[Study, Study]:
        """Cases and map."""
        return self.cases, self.workspace


def standard(
    cases: Sequence[Case], names: Collection[str] | None = None, *, quick: bool = False
) -> Plan:
    """Return the standard study at `cases`: of the models called `names` only, if given.

    `quick`: without models that take a second a pose. What cannot run here is skipped. Raises
    `InputError` for a name that no model has.
    """
    known = dict(catalogue())
    for name in names or ():
        if name not in known:
            raise InputError("models", name, f"some of {', '.join(known)}")
    skipped: dict[str, str] = {}
    ladders, exact, extrapolated = [], list[Named](), list[Named]()
    for name, info in known.items():
        if (names is not None and name not in names) or (quick and info.slow):
            skipped[name] = NOT_ASKED
        elif info.missing:
            skipped[name] = f"cannot run here: {info.missing}"
        else:
            ladders.append(tuple(Named(name, n) for n in info.ladder))
            exact += [Named(name, None)] if info.limit == name else []
            # Of a slow model the meshes themselves are enough.
            both = None if info.slow else info.refinements
            extrapolated += [Named(name, both)] if both else []
    chosen = known.keys() - skipped.keys()
    more, mapped = (tuple(m for m in some if m.name in chosen) for some in (GATE_MORE, GATE_MAP))
    singles = (*exact, *extrapolated, *more)
    plan = Plan(tuple(cases), tuple(ladders), singles, mapped, (), skipped,
                asked=frozenset(names or ()))  # fmt: skip
    try:
        return replace(plan, poses=workspace_cases(cases[0].mechanism, cases[0].pose.z))
    except InputError as error:
        return replace(plan, notes=(f"no map of the workspace: {error}",))


@cache
def workspace_cases(mechanism: Mechanism, z: float) -> tuple[Case, ...]:
    """Return the poses of the map: `LAYERS` x azimuths x `TILTS` from level to each rim.

    Layers and the limits of the limbs' lengths are those of the paper, in proportion to `z`.
    Raises `InputError` where a layer is out of reach.
    """
    if not mechanism.simple:
        raise InputError("mechanism", mechanism.limbs[0].described, "R-P-S limbs")
    scale, usual = z / HEIGHT, Limits()
    limits = Limits(usual.length_min * scale, usual.length_max * scale)
    region = regular_workspace(mechanism, [scale * layer for layer in LAYERS], limits)
    if region.radii.min() < LEAST:
        # Of four limbs and more the joints close at some azimuths only.
        raise InputError("mechanism", f"{len(mechanism.limbs)} limbs", "one that tilts any way")
    grid = region.grid(AROUND * len(mechanism.limbs), TILTS)
    flat = [np.broadcast_to(x, grid.shape).ravel() for x in (grid.z, grid.azimuth, grid.tilt)]
    found = []
    for pose in Pose(*flat):
        phi, theta = np.degrees([pose.azimuth, pose.tilt])
        name = f"{PLACE}{1000 * pose.z:g} mm, phi={phi:.6g} deg, theta={theta:.4f} deg"
        found.append(Case(name, mechanism, pose, "regular workspace"))
    return tuple(found)


def group(case: str) -> str:
    """Return what a case is called where all poses of the map are one."""
    return GATE if case.startswith(PLACE) else case


def solve(plan: Plan, bench: Bench) -> Checked:
    """Solve everything in the plan, with the yardstick before, between and after."""
    machine = [yardstick()]
    cases = bench.run(plan.cases, plan.everywhere, MODES)
    machine.append(yardstick())
    workspace = bench.run(plan.poses, plan.mapped, MODES)
    batches: dict[Model, Batch | Failure] = {
        model: batch(model, plan.poses)
        for model in (plan.mapped if plan.poses else ())
        if not model.info().isolated  # what runs in this process takes many poses a call
    }
    machine.append(yardstick())
    rows = cases.rows() + [row | {"case": GATE} for row in workspace.rows()]
    rows += [  # how long a model takes for a pose among many
        {"case": GATE, "model": f"{label(model)}, many poses a call", "mode": 1,
         "z_m": plan.poses[0].pose.z, "frequency_hz": float(one.table[0, 0]), "build_s": 0.0,
         "solve_s": one.seconds / len(plan.poses)}
        for model, one in batches.items() if isinstance(one, Batch)
    ]  # fmt: skip
    rows.append(yardstick_row(machine))
    return Checked(plan, bench, cases, workspace, batches, rows)


def batch(model: Model, cases: tuple[Case, ...]) -> Batch | Failure:
    """Return what a model gives for all `cases` in one call; its tables are made beforehand."""
    task = BatchTask(model, cases[0].mechanism, Pose.stacked([c.pose for c in cases]), MODES)
    attempt(replace(task, poses=task.poses[:2]))
    found = attempt(task)
    assert isinstance(found, (Batch, Failure)), "what the task gives"
    return found


def yardstick(masses: int = 150) -> tuple[float, float]:
    """Return the lowest frequency [Hz] of a chain and the median time of its eigen-solution [s].

    Unit masses and springs in a row between walls: omega_k = 2 sin(k pi / 2 (masses + 1)).
    """
    K, seconds = 2 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1), []
    for _ in range(REPEATS):
        began = time.perf_counter()
        values = np.linalg.eigh(K)[0]
        seconds.append(time.perf_counter() - began)
    return float(np.sqrt(values[0]) / (2 * np.pi)), median(seconds)


def yardstick_row(measured: Sequence[tuple[float, float]]) -> dict[str, Any]:
    """Return the row of the history for what `yardstick` gave during a run."""
    return {
        "case": YARDSTICK, "model": YARDSTICK, "theory": "springs and masses in a row",
        "version": f"numpy {np.__version__}", "mode": 1, "frequency_hz": measured[0][0],
        "build_s": 0.0, "solve_s": median(seconds for _, seconds in measured),
    }  # fmt: skip
