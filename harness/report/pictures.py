"""Pictures that need no script, as studies draw them: a mechanism at a pose, and Fig. 3."""

from base64 import b64encode
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from harness.case import Case
from harness.drawing import drawn
from harness.figures import own_style, picture
from harness.report.section import Json
from harness.studies.convergence import Convergence, convergence_figure
from harness.studies.shapes import KEY, rest_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PANELS = 2
"""Cases of Fig. 3 that the first screen has room for."""


def mechanism(case: Case) -> Json:
    """Return the mechanism of a case at its pose as a picture, and what its limbs are."""
    with own_style():
        figure = rest_figure(case)
    plain = drawn(case.mechanism, case.pose).plain
    chains = dict.fromkeys(limb.described for limb in case.mechanism.limbs)
    return {
        "picture": _embedded(figure, "png"),
        "chains": "" if plain else " and ".join(chains),
        "key": "" if plain else KEY,
        "caption": case.heading,
    }


def fig3(found: Convergence) -> Json:
    """Return Fig. 3 of a result, a picture for each of its first few cases, and its caption."""
    cases = [case for case, off in found.errors.items() if np.isfinite(off).any()]
    pictures, limit = [], found.theory.limit()
    for case in cases[:PANELS]:
        with own_style():
            figure = convergence_figure(replace(found, study=replace(found.study, cases=(case,))))
            figure.suptitle("")  # the caption says it
            figure.axes[0].set_title(case.heading)
        pictures.append({"title": case.heading, "picture": _embedded(figure, "svg+xml")})
    title = f"{found.theory.name} with s elements a limb against {found.reference.label}"
    return {"panels": pictures, "title": title, "limit": limit and limit.label}


def _embedded(figure: "Figure", kind: str) -> str:
    """Return a figure as the address of an image that holds it."""
    content = picture(figure, kind.partition("+")[0])
    return f"data:image/{kind};base64,{b64encode(content).decode()}"
