"""Pictures that need no script: a mechanism at a pose, as coordinates, and Fig. 3."""

from base64 import b64encode
from dataclasses import replace

import numpy as np

from harness.case import Case
from harness.drawing import at, drawn, seen
from harness.figures import own_style, picture
from harness.report.section import Json
from harness.studies.convergence import Convergence, convergence_figure

WIDE, HIGH = 320.0, 260.0
"""Size of the drawing of a mechanism."""
PANELS = 2
"""Cases of Fig. 3 that the first screen has room for."""


def mechanism(case: Case) -> Json:
    """Return the mechanism of a case at its pose as seen from the front: lines and outlines."""
    there = drawn(case.mechanism, case.pose)
    lines = there.limbs()
    ends = [at(lines[s.limb], np.array([s.begin, s.end])) for s in there.spans]
    parts = [there.ground, there.centre + there.rim(), there.marked(lines), *ends]
    flat, near = seen(np.concatenate(parts))
    low, high = flat.min(axis=0), flat.max(axis=0)
    scale = np.min((np.array([WIDE, HIGH]) - [110, 60]) / (high - low))
    placed = (flat - (low + high) / 2) * scale * [1, -1] + np.array([WIDE, HIGH]) / 2
    cuts = np.cumsum([len(part) for part in parts])[:-1]
    ground, platform, marks, *spans = (p.tolist() for p in np.split(np.round(placed, 1), cuts))
    nearness = [part.sum() for part in np.split(near, cuts)[3:]]
    chains = dict.fromkeys(limb.described for limb in case.mechanism.limbs)
    return {
        "width": WIDE,
        "height": HIGH,
        "base": ground,
        "platform": platform,
        "limbs": [
            {
                "from": spans[k][0],
                "to": spans[k][1],
                "width": round(float(2 * there.spans[k].radius * scale), 1),
            }
            for k in np.argsort(nearness)
        ],
        "joints": [
            {"x": x, "y": y, "kind": one.kind}
            for one, (x, y) in zip(there.marks, marks, strict=True)
        ],
        "chains": "" if there.plain else " and ".join(chains),
        "caption": case.heading,
    }


def fig3(found: Convergence) -> Json:
    """Return Fig. 3 of a result, its first few cases each as SVG in base64, and its caption."""
    cases = [case for case, off in found.errors.items() if np.isfinite(off).any()]
    pictures, limit = [], found.theory.limit()
    for case in cases[:PANELS]:
        with own_style():
            figure = convergence_figure(replace(found, study=replace(found.study, cases=(case,))))
            figure.suptitle("")  # the caption says it
        svg = b64encode(picture(figure, "svg")).decode()
        pictures.append({"title": case.heading, "svg": svg})
    title = f"{found.theory.name} with s elements a limb against {found.reference.label}"
    return {"panels": pictures, "title": title, "limit": limit and limit.label}
