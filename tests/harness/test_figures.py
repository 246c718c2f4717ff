"""Figures as files: three forms, 300 dots an inch, whatever the user's matplotlibrc says."""

import io
from typing import Any

import matplotlib as mpl
import pytest
from PIL import Image

from harness.api import study
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
    files = result_files(result, "fig")
    assert files["fig.svg"].startswith(b"<?xml") and files["fig.pdf"].startswith(b"%PDF")
    image = Image.open(io.BytesIO(files["fig.png"]))
    assert image.info["dpi"] == pytest.approx((300, 300), abs=0.1)
    assert image.width > 1200


def test_figures_do_not_depend_on_the_users_style(result: Result) -> None:
    usual = result_files(result, "fig")
    with mpl.rc_context(USERS):
        assert result_files(result, "fig") == usual
