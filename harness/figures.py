"""Pictures: matplotlib figures as bytes, the same bytes for the same numbers."""

import io
from collections.abc import Sequence

import matplotlib as mpl
from matplotlib.figure import Figure

# Okabe and Ito's colours, told apart by every common kind of colour vision; markers repeat the
# distinction, and differ in size because repeated modes lie on top of each other.
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "h")


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
