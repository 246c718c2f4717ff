"""Figures as files: three forms, 300 dots an inch, whatever the user's matplotlibrc says."""

import io
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from harness.api import study
from harness.figures import LINE, write_ends
from harness.output import result_files
from harness.result import Result

USERS: dict[Any, Any] = {
    "text.usetex": True, "figure.dpi": 20, "savefig.bbox": "tight", "lines.linewidth": 9,
    "svg.fonttype": "none", "axes.facecolor": "black",
}  # fmt: skip


@pytest.fixture(scope="module")
def result() -> Result:
    return study("convergence", references="timoshenko@exact", elements="1,2", cases="case1")


def test_every_figure_is_svg_png_and_pdf(result: Result) -> None:
    files = result_files({"fig": result})
    assert files["fig.svg"].startswith(b"<?xml") and files["fig.pdf"].startswith(b"%PDF")
    image = Image.open(io.BytesIO(files["fig.png"]))
    assert image.info["dpi"] == pytest.approx((300, 300), abs=0.1)
    assert image.width > 1200


def test_figures_do_not_depend_on_the_users_style(result: Result) -> None:
    usual = result_files({"fig": result})
    with mpl.rc_context(USERS):
        assert result_files({"fig": result}) == usual


@pytest.mark.parametrize("scale", ["linear", "log"])
def test_ends_are_written_in_order_none_over_another(scale: str) -> None:
    """Alone at its curve's height; of close ones each a line above the last."""
    axes = Figure().add_subplot()
    axes.plot([1, 2], [1, 1000])
    axes.set_yscale(scale)
    values = {"b": 100 + 1e-13, "a": 100.0, "lost": float("nan"), "c": 101.0, "alone": 1000.0}
    write_ends(axes, {"lost": float("nan")})
    assert not axes.texts
    write_ends(axes, values)
    assert [t.get_text() for t in axes.texts] == ["a 100", "b 100", "c 101", "alone 1.00e+03"]
    places = [text.get_position()[1] for text in axes.texts]
    assert np.diff(places[:3]) == pytest.approx([LINE, LINE])
    at = axes.transAxes.inverted().transform(axes.transData.transform([(1, 100), (1, 1000)]))[:, 1]
    assert [np.mean(places[:3]), places[3]] == pytest.approx(at, abs=0.01)
