"""Pictures that need no script, as studies draw them: a mechanism at a pose, and Fig. 3."""

import re
from base64 import b64encode
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from harness.case import Case
from harness.drawing import drawn
from harness.figures import COLOURS, own_style, picture
from harness.report.section import Json
from harness.studies.convergence import Convergence, convergence_figure
from harness.studies.shapes import KEY, rest_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PANELS = 2
"""Cases of Fig. 3 that the first screen has room for."""

INKS = {colour.lower(): f"var(--m{mode})" for mode, colour in enumerate(COLOURS, 1)} | {
    "#ffffff": "var(--paper)", "#b0b0b0": "var(--faint)", "#cccccc": "var(--rule)",
}  # fmt: skip
"""What the page calls the colours of curves, of ground, grid and frame, light or dark."""


def mechanism(case: Case) -> Json:
    """Return the mechanism of a case at its pose as a picture, and what its limbs are."""
    with own_style():
        figure = rest_figure(case)
    plain = drawn(case.mechanism, case.pose).plain
    chains = dict.fromkeys(limb.described for limb in case.mechanism.limbs)
    return {
        "picture": f"data:image/png;base64,{b64encode(picture(figure, 'png')).decode()}",
        "chains": "" if plain else " and ".join(chains),
        "key": "" if plain else KEY,
        "caption": case.heading,
    }


def fig3(found: Convergence) -> Json:
    """Return Fig. 3 of a result, a picture for each of its first few cases, and its caption."""
    cases = [case for case, off in found.errors.items() if np.isfinite(off).any()]
    pictures, limit = [], found.theory.limit()
    for k, case in enumerate(cases[:PANELS]):
        with own_style():
            figure = convergence_figure(replace(found, study=replace(found.study, cases=(case,))))
            figure.set_size_inches(4.4, 3.7)
            figure.suptitle("")  # the caption says it
            figure.axes[0].set_title(case.heading)
        pictures.append({"title": case.heading, "picture": _inline(figure, f"panel{k}")})
    title = f"{found.theory.name} with s elements a limb against {found.reference.label}"
    return {"panels": pictures, "title": title, "limit": limit and limit.label}


def _inline(figure: "Figure", name: str) -> str:
    """Return a figure as SVG in the page's colours, all ids beginning with `name`."""
    drawing = picture(figure, "svg").decode()
    drawing = re.sub(r'(id="|"#|\(#)', rf"\g<1>{name}-", drawing[drawing.index("<svg") :])
    for colour, own in INKS.items():
        drawing = drawing.replace(colour, own)
    return drawing.replace("*{", ".drawn *{")
