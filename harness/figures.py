"""Pictures: matplotlib figures as bytes, the same bytes for the same numbers."""

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Okabe and Ito's colours, told apart by every common kind of colour vision; markers repeat the
# distinction, and differ in size because repeated modes lie on top of each other.
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "h")
FORMS = ("svg", "png", "pdf")
DPI = 300
_UNDATED = {"svg": {"Date": None}, "png": {"Software": None}, "pdf": {"CreationDate": None}}


@contextmanager
def own_style() -> Iterator[None]:
    """Draw with matplotlib's defaults, whatever the user's matplotlibrc says."""
    import matplotlib as mpl

    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update({"svg.hashsalt": "rps-bench", "svg.fonttype": "path"})
        yield


def picture(figure: "Figure", form: str) -> bytes:
    """Return `figure` as "svg", "png" or "pdf" bytes, without dates or random names."""
    data = io.BytesIO()
    with own_style():
        figure.savefig(data, format=form, dpi=DPI, metadata=_UNDATED[form])
    return data.getvalue()


def figure_files(figure: "Figure", stem: str, forms: Sequence[str] = FORMS) -> dict[str, bytes]:
    """Return `stem` in all `forms` as files to write."""
    return {f"{stem}.{form}": picture(figure, form) for form in forms}
