"""Mode shapes, as in Figs. 4-5: limbs as tubes, the platform as a disc, beside a reference."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from analytic import STATIONS, Mechanism, Modes, Pose, limbs_at, position
from analytic.pairing import mass_vectors, repeated
from harness.bench import Bench, Study
from harness.cases import Case
from harness.compare import failure_notes
from harness.plan import Plan
from harness.request import Request
from harness.result import Result
from harness.tables import Cell, Number, Table
from reference_models import Named

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d.axes3d import Axes3D

Array = NDArray[np.float64]
OUTPUT = "shapes"
AMPLITUDE = 0.2
"""Largest displacement drawn, relative to the mean limb length."""
_RING = np.linspace(0, 2 * np.pi, 33)


@dataclass(frozen=True)
class Shapes(Result):
    """Modes of `theory` beside those of `references`; `shown`: mode numbers from 1."""

    study: Study
    theory: Named
    references: tuple[Named, ...]
    shown: tuple[int, ...]

    @property
    def studies(self) -> tuple[Study, ...]:
        """What was solved for it."""
        return (self.study,)

    def to_frame(self) -> "pd.DataFrame":
        """Return one row a case, reference and pair of modes: the assurance of the two."""
        import pandas as pd

        return pd.DataFrame([
            {
                "case": case.name,
                "theory": self.theory.label,
                "reference": reference.label,
                "mode": i,
                "reference_mode": j + 1,
                "assurance": float(value),
                "partner": j == pairing.partner[i - 1],
            }
            for case in self.study.cases
            for reference in self.references
            if (pairing := self.study.pairing(case, self.theory, reference)) is not None
            for i in self.shown
            for j, value in enumerate(pairing.matrix[i - 1])
        ])  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return each mode's partner in every reference, and how alike the two are."""
        rows: list[tuple[Cell, ...]] = []
        for case in self.study.cases:
            for reference in self.references:
                ours, theirs = self.study.get(case, self.theory), self.study.get(case, reference)
                pairing = self.study.pairing(case, self.theory, reference)
                if ours is None or theirs is None or pairing is None:
                    continue
                for i in self.shown:
                    j = int(pairing.partner[i - 1])
                    rows.append((
                        case.name, reference.label, f"f{i}",
                        Number(float(ours.frequencies[i - 1])), f"f{j + 1}",
                        Number(float(theirs.frequencies[j])),
                        Number(float(pairing.assurance[i - 1]), 4),
                        "looks like no mode of the reference" if pairing.doubtful[i - 1] else "",
                    ))  # fmt: skip
        columns = ("Case", "Reference", "Mode", "f [Hz]", "Partner", "its f [Hz]", "Assurance",
                   "Remark")  # fmt: skip
        notes = (
            "assurance: (a . b)^2 / (a . a) (b . b), mass-weighted; modes that repeat are compared "
            "as one subspace",
            f"pictures: the largest displacement is drawn as {AMPLITUDE:g} of the mean limb length",
            *failure_notes(self.study),
        )
        title = f"Mode shapes of {self.theory.label} and their partners"
        return {"": Table(title, columns, tuple(rows), notes)}

    def figures(self) -> "dict[str, Figure]":
        """Return the modes of every case, and the assurance of every mode against every one."""
        models = (self.theory, *self.references)
        found = {
            f"-{case.name}": shapes_figure(self.study, case, models, self.shown)
            for case in self.study.cases
        }
        for case in self.study.cases:
            for reference in self.references:
                matrix = assurance_figure(self.study, case, self.theory, reference, self.shown)
                if matrix is not None:
                    found[f"-assurance-{case.name}-{reference.label}"] = matrix
        return found

    def sentences(self) -> list[str]:
        """Return the smallest assurance of a mode with its partner, reference by reference."""
        lines, pick = [], [i - 1 for i in self.shown]
        for reference in self.references:
            pairings = [self.study.pairing(c, self.theory, reference) for c in self.study.cases]
            least = [float(p.assurance[pick].min()) for p in pairings if p is not None]
            if least:
                lines.append(
                    f"Every mode of {self.theory.label} has its partner in {reference.label} with "
                    f"an assurance of at least {min(least):.4f}."
                )
        return lines


def run(request: Request, bench: Bench) -> Shapes:
    """Return the theory's modes beside the references', with the assurance of every pair.

    Pictures and matrices are written where --output is given.
    """
    models = (request.theory, *request.references)
    study = bench.run(request.cases, models, request.count)
    return Shapes(study, request.theory, request.references, request.shown)


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: beside the first reference and the solid."""
    return {"shapes": plan.request(references=plan.against)}


@dataclass(frozen=True)
class Turned:
    """A reference's modes as they are drawn: fields as of `Modes`."""

    frequencies: Array
    platform: Array
    limbs: Array


def aligned(study: Study, case: Case, theory: Named, reference: Named) -> Turned | None:
    """Return the reference's modes in the theory's order, signs and, where repeated, basis.

    Any basis of a repeated pair is as good as another: the reference's is turned to the theory's by
    the nearest rotation (orthogonal Procrustes). None where either model failed.
    """
    from scipy.linalg import orthogonal_procrustes

    ours, theirs = study.first(case, theory), study.get(case, reference)
    pairing = study.pairing(case, theory, reference)
    if ours is None or theirs is None or pairing is None:
        return None
    place = pairing.partner
    a, b = (mass_vectors(modes, case.mechanism, case.pose) for modes in (ours, theirs))
    b, platform, limbs = b[place], theirs.platform[place], theirs.limbs[place]
    for group in repeated(ours.frequencies):
        turn, _ = orthogonal_procrustes(b[group].T, a[group].T)
        platform[group] = turn.T @ platform[group]
        limbs[group] = np.einsum("ij,j...->i...", turn.T, limbs[group])
    return Turned(theirs.frequencies[place], platform, limbs)


def shapes_figure(
    study: Study, case: Case, models: Sequence[Named], shown: Sequence[int]
) -> "Figure":
    """Return one row of pictures a model, one column a mode; the undeformed shape is faint."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(2.5 * len(shown), 3.0 * len(models) + 0.4), layout="constrained")
    panels = figure.subplots(
        len(models), len(shown), squeeze=False, subplot_kw={"projection": "3d"}
    )
    for row, (model, strip) in enumerate(zip(models, panels, strict=True)):
        modes = study.get(case, model) if row == 0 else aligned(study, case, models[0], model)
        for i, axes in zip(shown, strip, strict=True):
            axes.set_axis_off()
            if modes is None:
                axes.set_title("failed", fontsize=9)
                continue
            draw_mode(axes, case.mechanism, case.pose, modes, i - 1)
            letter = f"({chr(96 + i)}) " if i <= 26 else ""
            axes.set_title(f"{letter}$f_{{{i}}}$ = {modes.frequencies[i - 1]:.2f} Hz", fontsize=10)
        strip[0].text2D(-0.02, 0.5, model.label, transform=strip[0].transAxes, rotation=90,
                        va="center", ha="right", fontsize=9)  # fmt: skip
    figure.suptitle(
        f"Mode shapes of {case.name}; the largest displacement is drawn as {AMPLITUDE:g} of the "
        "mean limb length", fontsize=11,
    )  # fmt: skip
    return figure


def draw_mode(
    axes: "Axes3D", mechanism: Mechanism, pose: Pose, modes: Modes | Turned, i: int
) -> None:
    """Draw mode `i` over the undeformed mechanism."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

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
            # As a picture within the drawing: a page of vectors has a hundred thousand faces.
            axes.plot_surface(x, y, z, color=colour, alpha=alpha, linewidth=0, shade=alpha == 1,
                              rasterized=True)  # fmt: skip
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
    study: Study, case: Case, theory: Named, reference: Named, shown: Sequence[int]
) -> "Figure | None":
    """Return the assurance criterion of every mode against every one, or None where one failed."""
    from matplotlib.figure import Figure

    pairing = study.pairing(case, theory, reference)
    if pairing is None:
        return None
    matrix = pairing.matrix[[i - 1 for i in shown]]
    figure = Figure(
        figsize=(1 + 0.55 * matrix.shape[1], 1.2 + 0.5 * len(shown)), layout="constrained"
    )
    axes = figure.subplots()
    image = axes.imshow(matrix, cmap="Blues", vmin=0, vmax=1)
    for (i, j), value in np.ndenumerate(matrix):
        axes.text(j, i, f"{value:.2f}", ha="center", va="center", fontsize=7,
                  color="white" if value > 0.6 else "0.3")  # fmt: skip
    axes.set_xticks(range(matrix.shape[1]), [f"{j + 1}" for j in range(matrix.shape[1])])
    axes.set_yticks(range(len(shown)), [f"{i}" for i in shown])
    axes.set(xlabel=f"mode of {reference.label}", ylabel=f"mode of {theory.label}")
    axes.set_title(f"{case.name}: assurance (mass-weighted)", fontsize=10)
    figure.colorbar(image, shrink=0.8)
    return figure
