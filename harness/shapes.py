"""Mode shapes, as in Figs. 4-5: limbs as tubes, the platform as a disc, beside a reference."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D
from numpy.typing import NDArray
from scipy.linalg import orthogonal_procrustes

from analytic import STATIONS, Mechanism, Modes, Pose, limbs_at, position
from analytic.pairing import mass_vectors, repeated
from harness.cases import Case
from harness.models import Spec
from harness.run import Study

Array = NDArray[np.float64]
AMPLITUDE = 0.2
"""Largest displacement drawn, relative to the mean limb length."""
_RING = np.linspace(0, 2 * np.pi, 33)


def aligned(study: Study, case: Case, theory: Spec, reference: Spec) -> Modes | None:
    """Return the reference's modes in the theory's order, signs and, where repeated, basis.

    Any basis of a repeated pair is as good as another: the reference's is turned to the theory's by
    the nearest rotation (orthogonal Procrustes). None where either model failed.
    """
    ours, theirs = study.get(case, theory), study.get(case, reference)
    pairing = study.pairing(case, theory, reference)
    if ours is None or theirs is None or pairing is None:
        return None
    place = pairing.partner
    picked = replace(
        theirs,
        frequencies=theirs.frequencies[place],
        platform=theirs.platform[place],
        limbs=theirs.limbs[place],
        uncertainty=None,
    )
    ours = ours.first(study.count)
    a, b = (mass_vectors(modes, case.mechanism, case.pose) for modes in (ours, picked))
    platform, limbs = picked.platform.copy(), picked.limbs.copy()
    for group in repeated(ours.frequencies):
        turn, _ = orthogonal_procrustes(b[group].T, a[group].T)
        platform[group] = turn.T @ platform[group]
        limbs[group] = np.einsum("ij,j...->i...", turn.T, limbs[group])
    turned = replace(picked)
    # Modes turn themselves upright at construction; here the theory's sign decides.
    object.__setattr__(turned, "platform", platform)
    object.__setattr__(turned, "limbs", limbs)
    return turned


def shapes_figure(study: Study, case: Case, specs: Sequence[Spec], shown: Sequence[int]) -> Figure:
    """Return one row of pictures a model, one column a mode; the undeformed shape is faint."""
    figure = Figure(figsize=(2.5 * len(shown), 3.0 * len(specs) + 0.4), layout="constrained")
    panels = figure.subplots(len(specs), len(shown), squeeze=False, subplot_kw={"projection": "3d"})
    for row, (spec, strip) in enumerate(zip(specs, panels, strict=True)):
        modes = study.get(case, spec) if row == 0 else aligned(study, case, specs[0], spec)
        for i, axes in zip(shown, strip, strict=True):
            axes.set_axis_off()
            if modes is None:
                axes.set_title("failed", fontsize=9)
                continue
            draw_mode(axes, case.mechanism, case.pose, modes, i - 1)
            label = f"({chr(96 + i)}) " if i <= 26 else ""
            axes.set_title(f"{label}$f_{{{i}}}$ = {modes.frequencies[i - 1]:.2f} Hz", fontsize=10)
        strip[0].text2D(-0.02, 0.5, spec.label, transform=strip[0].transAxes, rotation=90,
                        va="center", ha="right", fontsize=9)  # fmt: skip
    figure.suptitle(f"Mode shapes of {case.name}", fontsize=11)
    return figure


def draw_mode(axes: Axes3D, mechanism: Mechanism, pose: Pose, modes: Modes, i: int) -> None:
    """Draw mode `i` over the undeformed mechanism."""
    limbs = limbs_at(mechanism, pose)
    o, R = position(mechanism, pose), pose.rotation
    scale = AMPLITUDE * limbs.lengths.mean() / np.abs(modes.limbs[i]).max(initial=1e-12)
    shift, spin = scale * modes.platform[i, :3], scale * modes.platform[i, 3:]
    for k, limb in enumerate(mechanism.limbs):
        frame, base = limbs.frames[k], np.array(limb.base)
        line = base + STATIONS[:, None] * limbs.lengths[k] * frame[:, 2]
        for points, colour, alpha in (
            (line, "0.6", 0.25), (line + scale * modes.limbs[i, k], "#0072B2", 1.0)
        ):  # fmt: skip
            x, y, z = tube(points, frame, limb.rod.diameter / 2)
            axes.plot_surface(x, y, z, color=colour, alpha=alpha, linewidth=0, shade=alpha == 1)
    radius = np.linalg.norm(mechanism.platform_points, axis=1).max()
    arms = radius * np.stack([np.cos(_RING), np.sin(_RING), 0 * _RING], axis=1) @ R.T
    for points, colour, alpha in (
        (o + arms, "0.6", 0.25), (o + shift + arms + np.cross(spin, arms), "#E69F00", 0.8)
    ):  # fmt: skip
        axes.add_collection3d(Poly3DCollection([points], facecolor=colour, alpha=alpha, lw=0))
    reach = 1.05 * max(float(np.abs(mechanism.bases[:, :2]).max()), float(o[2]) / 2)
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), zlim=(0, 1.05 * o[2] + 0.1 * reach))
    axes.set_box_aspect((2 * reach, 2 * reach, 1.05 * o[2] + 0.1 * reach), zoom=1.2)
    axes.view_init(elev=18, azim=-60)


def tube(points: Array, frame: Array, radius: float) -> tuple[Array, Array, Array]:
    """Return x, y, z of a tube of `radius` around `points` (k, 3), each (k, 33)."""
    ring = np.cos(_RING)[:, None] * frame[:, 0] + np.sin(_RING)[:, None] * frame[:, 1]
    surface = points[:, None] + radius * ring
    return surface[..., 0], surface[..., 1], surface[..., 2]


def assurance_figure(
    study: Study, case: Case, theory: Spec, reference: Spec, shown: Sequence[int]
) -> Figure | None:
    """Return the assurance criterion of every mode against every one, or None where one failed."""
    pairing = study.pairing(case, theory, reference)
    if pairing is None:
        return None
    pick = [i - 1 for i in shown]
    matrix = pairing.matrix[pick]
    figure = Figure(
        figsize=(1 + 0.55 * matrix.shape[1], 1.2 + 0.5 * len(pick)), layout="constrained"
    )
    axes = figure.subplots()
    image = axes.imshow(matrix, cmap="Blues", vmin=0, vmax=1)
    for (i, j), value in np.ndenumerate(matrix):
        axes.text(j, i, f"{value:.2f}", ha="center", va="center", fontsize=7,
                  color="white" if value > 0.6 else "0.3")  # fmt: skip
    axes.set_xticks(range(matrix.shape[1]), [f"{j + 1}" for j in range(matrix.shape[1])])
    axes.set_yticks(range(len(pick)), [f"{i}" for i in shown])
    axes.set(xlabel=f"mode of {reference.label}", ylabel=f"mode of {theory.label}")
    axes.set_title(f"{case.name}: assurance (mass-weighted)", fontsize=10)
    figure.colorbar(image, shrink=0.8)
    return figure
