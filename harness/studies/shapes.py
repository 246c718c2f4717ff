"""Mode shapes, as in Figs. 4-5: limbs as tubes, the platform as a disc, beside a reference."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np

from analytic.pairing import mass_vectors, repeated
from harness.bench import Bench, Study
from harness.case import Case
from harness.compare import Match, at, cell, failure_notes, match
from harness.drawing import AMPLITUDE, Drawn, drawn, scale
from harness.figures import COLOURS, panels
from harness.request import Plan, Request
from harness.result import Result
from harness.signatures import Array, Figure
from harness.tables import Table
from reference_models import Named

OUTPUT = "shapes"
MARKS = {
    "R": ("o", 4.0, "w"), "U": ("P", 4.5, "w"), "S": ("o", 4.0, "k"), "P": ("s", 5.0, COLOURS[2]),
    "fixed": ("d", 4.0, "0.5"), "body": ("h", 5.5, COLOURS[4]),
}  # fmt: skip
"""How joints and bodies are marked: form, size and colour."""
SPACE = {"projection": "3d", "proj_type": "ortho", "azim": -60, "elev": 18}
"""From where a mechanism is looked at."""
LETTERS = 13
"""Letters of a title an inch."""
KEY = (
    "Open circle R, plus U, black circle S, green square P, diamond fixed, hexagon a body, cross "
    "the platform's centre of mass."
)


@dataclass(frozen=True)
class Shapes(Result):
    """Modes of `theory` beside those of `references`; `shown`: mode numbers from 1."""

    study: Study
    theory: Named
    references: tuple[Named, ...]
    shown: tuple[int, ...]

    def _pairs(self) -> Iterator[tuple[Case, Named, Match]]:
        for case, reference in product(self.study.cases, self.references):
            if found := match(self.study, case, self.theory, reference):
                yield case, reference, found

    def records(self) -> Iterator[dict[str, Any]]:
        """Return one row a case, reference and pair of modes: the assurance of the two."""
        for case, reference, found in self._pairs():
            for i in self.shown:
                for j, value in enumerate(found.pairing.matrix[i - 1].tolist()):
                    yield {
                        "case": case.name, "theory": self.theory.label,
                        "reference": reference.label, "mode": i, "reference_mode": j + 1,
                        "assurance": value, "partner": j == found.pairing.partner[i - 1],
                    }  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return each mode's partner in every reference, and how alike the two are."""
        rows = [
            (case.name, reference.label, f"f{k + 1}", cell(found.ours[k], 3),
             f"f{found.pairing.partner[k] + 1}", cell(found.against[k], 3),
             cell(found.pairing.assurance[k], 4),
             "looks like no mode of the reference" if found.pairing.doubtful[k] else "")
            for case, reference, found in self._pairs() for k in (i - 1 for i in self.shown)
        ]  # fmt: skip
        columns = ("Case", "Reference", "Mode", "f [Hz]", "Partner", "its f [Hz]", "Assurance",
                   "Remark")  # fmt: skip
        notes = (
            "assurance: (a . b)^2 / (a . a) (b . b), mass-weighted; modes that repeat are compared "
            "as one subspace",
            f"pictures: the largest displacement is drawn as {AMPLITUDE:g} of the mean limb length",
            *failure_notes(self.study),
        )
        title = f"Mode shapes of {self.theory.label} and their partners"
        return {"": Table(title, columns, rows, notes)}

    def figures(self) -> dict[str, Figure]:
        """Return the modes of every case, and the assurance of every mode against every one."""
        figures = {f"-{case.name}": shapes_figure(self, case) for case in self.study.cases}
        for case, reference, found in self._pairs():
            name = f"-assurance-{case.name}-{reference.label}"
            figures[name] = assurance_figure(self, case, reference, found)
        return figures

    def sentences(self) -> list[str]:
        """Return the smallest assurance of a mode with its partner, reference by reference."""
        alike: dict[str, list[float]] = {reference.label: [] for reference in self.references}
        for _, reference, found in self._pairs():
            alike[reference.label] += at(found.pairing.assurance, self.shown).tolist()
        return [
            f"Every mode of {self.theory.label} has its partner in {name} with an assurance of at "
            f"least {min(found):.4f}."
            for name, found in alike.items() if found
        ]  # fmt: skip


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


class Turned(NamedTuple):
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

    if (pairing := study.pairing(case, theory, reference)) is None:
        return None
    ours, theirs = study.answers[case, theory].first(study.count), study.answers[case, reference]
    place = pairing.partner
    a, b = (mass_vectors(modes, case.mechanism, case.pose) for modes in (ours, theirs))
    b, platform, limbs = b[place], theirs.platform[place], theirs.limbs[place]
    for group in repeated(ours.frequencies):
        turn, _ = orthogonal_procrustes(b[group].T, a[group].T)
        platform[group] = turn.T @ platform[group]
        limbs[group] = np.einsum("ij,j...->i...", turn.T, limbs[group])
    return Turned(theirs.frequencies[place], platform, limbs)


def shapes_figure(result: Shapes, case: Case) -> Figure:
    """Return one row of pictures a model, one column a mode, all of one size and view."""
    models, shown = (result.theory, *result.references), result.shown
    there = drawn(case.mechanism, case.pose)
    said = (
        f"Mode shapes, {case.heading}. The largest displacement is drawn as {AMPLITUDE:g} of the "
        f"mean limb length; dashed: at rest.{'' if there.plain else f' {KEY}'}"
    )
    title = fill(said, int(LETTERS * 2.1 * len(shown)))
    size = len(models), len(shown)
    figure, grid = panels(title, *size, (2.1, 2.4), subplot_kw=SPACE)
    outline = [*there.limbs(), there.disc(np.zeros(6))]
    for model, strip in zip(models, grid, strict=True):
        modes = aligned(result.study, case, result.theory, model)
        for i, axes in zip(shown, strip, strict=True):
            if modes is None:
                axes.set_axis_off()
                axes.set_title("failed", fontsize=9)
                continue
            platform, limbs = modes.platform[i - 1], modes.limbs[i - 1]
            for line in outline:
                axes.plot(*line.T, color="0.45", lw=0.9, ls=(0, (3, 2)), zorder=103)
            enlarged = float(scale(there, limbs))
            draw(axes, there, enlarged * platform, enlarged * limbs)
            letter = f"({chr(96 + i)}) " if i <= 26 else ""
            axes.set_title(f"{letter}$f_{{{i}}}$ = {modes.frequencies[i - 1]:.2f} Hz", fontsize=10)
        strip[0].text2D(-0.1, 0.5, model.label, fontsize=9, rotation=90, va="center",
                        transform=strip[0].transAxes)  # fmt: skip
    return figure


def rest_figure(case: Case) -> Figure:
    """Return the mechanism of a case at rest, with its joints, on no ground of its own."""
    figure, ((axes,),) = panels("", 1, 1, (3.6, 3.2), subplot_kw=SPACE)
    figure.set_facecolor("none")
    axes.set_facecolor("none")
    there = drawn(case.mechanism, case.pose)
    draw(axes, there, np.zeros(6), 0.0)
    if there.plain:
        draw_marks(axes, there, 0.0, np.zeros(6))
    return figure


def draw(axes: Any, there: Drawn, platform: Array, limbs: Array | float) -> None:
    """Draw a mechanism moved by so much; what is nearer hides what is not."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    axes.set_axis_off()
    for surface in there.rods(limbs):
        # As a picture within the drawing: a page of vectors has a hundred thousand faces.
        axes.plot_surface(*np.moveaxis(surface, -1, 0), color=COLOURS[0], rasterized=True)
    axes.add_collection3d(Poly3DCollection([there.disc(platform)], facecolors=COLOURS[1]))
    axes.plot(*there.ground.T, color="0.6", lw=1, zorder=1)
    if not there.plain:
        draw_marks(axes, there, limbs, platform)
    axes.set_aspect("equal")
    axes.set_box_aspect(None, zoom=1.35)


def draw_marks(axes: Any, there: Drawn, limbs: Array | float, platform: Array) -> None:
    """Draw joints and bodies by their kind, rails of sliders, and the platform's centre of mass."""
    for rail in zip(there.bases, there.starts, strict=True):
        axes.plot(*np.transpose(rail), color="0.6", lw=1.4, zorder=1)
    for one, point in zip(there.marks, there.marked(there.limbs(limbs)), strict=True):
        form, size, colour = MARKS.get(one.kind, MARKS["fixed"])
        axes.plot(*point[:, None], marker=form, ms=size, mfc=colour, ls="", mec="k", mew=0.5,
                  zorder=104)  # fmt: skip
    moved = there.mass + platform[:3] + np.cross(platform[3:], there.mass - there.centre)
    axes.plot(*moved[:, None], marker="X", ms=4.5, mfc="k", mec="w", mew=0.4, ls="", zorder=105)


def assurance_figure(result: Shapes, case: Case, reference: Named, found: Match) -> Figure:
    """Return the assurance criterion of every mode against every one."""
    matrix, shown = found.pairing.matrix[[i - 1 for i in result.shown]], result.shown
    size = (1 + 0.55 * matrix.shape[1], 1.2 + 0.5 * len(shown))
    title = f"Assurance weighted by mass. {case.heading}"
    figure, ((axes,),) = panels(title, 1, 1, size)
    image = axes.imshow(matrix, cmap="Blues", vmin=0, vmax=1)
    for (i, j), value in np.ndenumerate(matrix):
        axes.text(j, i, f"{value:.2f}", ha="center", va="center", fontsize=7,
                  color="white" if value > 0.6 else "0.3")  # fmt: skip
    axes.set_xticks(range(matrix.shape[1]), [f"{j + 1}" for j in range(matrix.shape[1])])
    axes.set_yticks(range(len(shown)), [f"{i}" for i in shown])
    axes.set(xlabel=f"mode of {reference.label}", ylabel=f"mode of {result.theory.label}")
    figure.supxlabel("modes that repeat are compared as one subspace", fontsize=7)
    figure.colorbar(image, shrink=0.8)
    return figure
