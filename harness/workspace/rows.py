"""A workspace map as rows of the history of runs."""

from dataclasses import replace
from typing import Any

import numpy as np

from analytic import Pose
from analytic.solid_limb import SolidLimb
from harness.cases import Case
from harness.run import MAP, mode_rows, settings
from harness.workspace.map import WorkspaceMap


def history_rows(data: WorkspaceMap) -> list[dict[str, Any]]:
    """Return one row a pose and mode, as of `harness.run.rows`: a level platform once a layer."""
    poses = data.grid.pose(*np.nonzero(data.grid.wanted))
    if data.answers.seconds is not None:
        return _of_batch(data, poses, data.answers.seconds)
    count = data.frequencies.shape[-1]
    chosen = settings(data.spec, count)
    result = []
    for i, modes in data.answers.modes.items():
        case = Case(MAP, data.region.mechanism, poses[i], "")
        result += mode_rows(case, data.spec, chosen, modes, count)
    return result


def _of_batch(data: WorkspaceMap, poses: Pose, seconds: float) -> list[dict[str, Any]]:
    """Return the rows of a model that took all poses at once, in `seconds` a pose."""
    f, spec, mechanism = data.answers.frequencies, data.spec, data.region.mechanism
    count, model = f.shape[1], spec.build()
    # What it says of itself it says at any one pose.
    modes = replace(
        model.modes(mechanism, poses[0], count), build_seconds=0.0, solve_seconds=seconds
    )
    if spec.analytic:
        modes = replace(modes, version="rps-bench, condensed")
    first = mode_rows(Case(MAP, mechanism, poses[0], ""), spec, settings(spec, count), modes, count)
    error = np.full(f.shape, np.nan)
    if isinstance(model, SolidLimb):
        error = model.uncertainty(mechanism, poses, f)
    result = []
    for pose, values, errors in zip(poses, f.tolist(), error.tolist(), strict=True):
        place = {"z_m": pose.z, "azimuth_rad": pose.azimuth, "tilt_rad": pose.tilt}
        result += [
            row | place | {"frequency_hz": value, "uncertainty_hz": own}
            for row, value, own in zip(first, values, errors, strict=True)
        ]
    return result
