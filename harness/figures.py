"""Pictures: matplotlib figures as bytes, the same bytes for the same numbers."""

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullFormatter, ScalarFormatter

from harness import published

if TYPE_CHECKING:
    from harness.convergence import Convergence

# Okabe and Ito's colours, told apart by every common kind of colour vision; markers repeat the
# distinction, and differ in size because repeated modes lie on top of each other.
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "h")


def convergence_figure(result: "Convergence", shown: Sequence[int]) -> Figure:
    """Return Fig. 3: error against s, one panel a case, (a), (b) ...; hollow: printed values.

    Against the theory's own limit the axes are logarithmic, and a line shows fourth order.
    """
    cases = result.study.cases
    figure = Figure(figsize=(5.2 * len(cases), 4.2), layout="constrained")
    panels = figure.subplots(1, len(cases), squeeze=False, sharey=result.same_theory)[0]
    for letter, (axes, case) in enumerate(zip(panels, cases, strict=True)):
        errors = result.errors[case.name]
        for i in shown:
            style = {"color": COLOURS[(i - 1) % 6], "marker": MARKERS[(i - 1) % 6]}
            values = np.abs(errors[:, i - 1]) if result.same_theory else errors[:, i - 1]
            size = 9 - 4 * ((i - 1) % 2)
            axes.plot(result.elements, values, **style, markersize=size, lw=1.2, label=f"$e_{i}$")
            if result.same_theory:
                continue
            for s in result.elements:
                quoted = published.figure3().get((case.published, s, i))
                if quoted is not None:
                    axes.plot(s, quoted, **style, markersize=11, mfc="none", ls="none", alpha=0.6)
        axes.set_xlabel("number of elements $s$")
        axes.set_title(f"({chr(97 + letter)}) {case.name}", fontsize=11)
        axes.grid(alpha=0.25)
        if result.same_theory:
            _logarithmic(axes, result, errors)
        else:
            axes.axhline(0, color="0.4", lw=0.8)
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    what = "discretisation error" if result.same_theory else "relative error"
    panels[0].set_ylabel(f"{what} [%]")
    panels[-1].legend(fontsize=9)
    hollow = "" if result.same_theory else "; hollow: values printed in the paper"
    figure.suptitle(f"{result.theory.name}@s against {result.reference.label}{hollow}", fontsize=10)
    return figure


def _logarithmic(axes: mpl.axes.Axes, result: "Convergence", errors: np.ndarray) -> None:
    s = np.array(result.elements, dtype=float)
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xticks(s)
    slope = 4 if result.theory.name == "euler-bernoulli" else 2
    top = np.nanmax(np.abs(errors[0]))
    axes.plot(s, 2 * top * (s / s[0]) ** -slope, ls=":", color="0.4", label=f"order {slope}")


def picture(figure: Figure, form: str) -> bytes:
    """Return `figure` as "svg" or "png" bytes, without dates or random names."""
    data = io.BytesIO()
    metadata = {"Date": None} if form == "svg" else {"Software": None}
    with mpl.rc_context({"svg.hashsalt": "rps-bench", "svg.fonttype": "path"}):
        figure.savefig(data, format=form, dpi=150, metadata=metadata)
    return data.getvalue()


def figure_files(
    figure: Figure, stem: str, forms: Sequence[str] = ("svg", "png")
) -> dict[str, bytes]:
    """Return `stem` in all `forms` as files to write."""
    return {f"{stem}.{form}": picture(figure, form) for form in forms}
