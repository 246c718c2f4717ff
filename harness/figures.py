"""Pictures: matplotlib figures as bytes, the same bytes for the same numbers."""

import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from harness.signatures import Axes, Figure

# Okabe and Ito's colours, told apart by every common kind of colour vision; markers repeat the
# distinction, and differ in size because repeated modes lie on top of each other.
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "h")
DPI = 300
LINE = 0.045
"""Height of a line of text, as a part of a panel's."""
FORMS = {"svg": {"Date": None}, "png": {"Software": None}, "pdf": {"CreationDate": None}}
"""Forms of a picture's file, and what is left out of each: dates and names of programs."""


@contextmanager
def own_style() -> Iterator[None]:
    """Draw with matplotlib's defaults, whatever the user's matplotlibrc says."""
    import matplotlib as mpl

    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update({"svg.hashsalt": "rps-bench", "svg.fonttype": "path"})
        yield


def panels(
    title: str,
    rows: int,
    columns: int,
    size: tuple[float, float],
    heads: Sequence[str] = (),
    **how: Any,
) -> tuple[Figure, Any]:
    """Return a figure with `title`, and its panels (rows, columns), each of `size` in inches.

    The panels of a row are called "(a) HEAD", "(b) HEAD" ... where there are `heads`.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(size[0] * columns, size[1] * rows), layout="constrained")
    figure.suptitle(title, fontsize=10)
    found = figure.subplots(rows, columns, squeeze=False, **how)
    for letter, (axes, head) in enumerate(zip(found[0], heads, strict=False)):
        axes.set_title(f"({chr(97 + letter)}) {head}", fontsize=11)
    return figure, found


def look(mode: int) -> dict[str, Any]:
    """Return how curves of a mode are drawn: of two that coincide the larger marker shows."""
    i = (mode - 1) % 6
    return {"color": COLOURS[i], "marker": MARKERS[i], "markersize": 9 - 4 * (i % 2), "lw": 1.2,
            "label": f"$e_{{{mode}}}$"}  # fmt: skip


def write_ends(axes: Axes, values: Mapping[str, float]) -> None:
    """Write names and values of curves beside their right ends, none over another."""
    found = {name: value for name, value in values.items() if np.isfinite(value)}
    # Modes that repeat stand in their own order, not in that of what rounding left of them.
    names = sorted(found, key=lambda name: (float(f"{found[name]:.3g}"), name))
    axes.autoscale_view()  # settles what is transformed to
    ends = np.array([(1, found[name]) for name in names]).reshape(-1, 2)
    heights = (axes.transScale + axes.transLimits).transform(ends)[:, 1]
    lines = LINE * np.arange(len(names))
    lowest = np.clip(heights, 0, 1) - lines
    up, down = np.maximum.accumulate(lowest), np.minimum.accumulate(lowest[::-1])[::-1]
    for name, y in zip(names, (up + down) / 2 + lines, strict=True):
        text = f"{name} {found[name]:#.3g}".rstrip(".")
        axes.text(1.015, y, text, transform=axes.transAxes, va="center", fontsize=9)


def picture(figure: Figure, form: str) -> bytes:
    """Return `figure` as "svg", "png" or "pdf" bytes, without dates or random names."""
    data = io.BytesIO()
    with own_style():
        figure.savefig(data, format=form, dpi=DPI, metadata=FORMS[form])
    return data.getvalue()


def figure_files(figure: Figure, stem: str) -> dict[str, bytes]:
    """Return `stem` in all `FORMS` as files to write."""
    return {f"{stem}.{form}": picture(figure, form) for form in FORMS}
