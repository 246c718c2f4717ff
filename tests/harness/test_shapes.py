"""Mode shapes beside each other: same order, same sign, same basis; and their pictures."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from harness.cases import PRESETS
from harness.models import Spec
from harness.run import Study, run
from harness.shapes import aligned, tube

THEORY, REFERENCE = Spec("euler-bernoulli", 6), Spec("exudyn-cable", 6)


@pytest.fixture(scope="module")
def study() -> Study:
    return run([PRESETS["case1"], PRESETS["case2"]], [THEORY, REFERENCE], 6)


@pytest.mark.parametrize("name", ["case1", "case2"])
def test_a_reference_is_turned_to_the_theory(study: Study, name: str) -> None:
    """Also the repeated pairs of case 1, whose basis either model is free to choose."""
    case = PRESETS[name]
    ours, theirs = study.modes[name, THEORY.label].first(6), aligned(study, case, THEORY, REFERENCE)
    assert theirs is not None
    size = np.abs(ours.limbs).max(axis=(1, 2, 3))
    off = np.abs(theirs.limbs - ours.limbs).max(axis=(1, 2, 3)) / size
    assert off.max() < 2e-3
    np.testing.assert_allclose(
        theirs.platform, ours.platform, atol=2e-3 * np.abs(ours.platform).max()
    )
    np.testing.assert_allclose(theirs.frequencies, ours.frequencies, rtol=1e-5)


def test_a_tube_has_its_radius() -> None:
    line = np.linspace([0.0, 0, 0], [0, 0, 1], 5)
    x, y, z = tube(line, np.eye(3), 0.05)
    np.testing.assert_allclose(np.hypot(x, y), 0.05)
    np.testing.assert_allclose(z, np.broadcast_to(line[:, 2:], z.shape))


def test_pictures(rps_bench: Callable[..., Any], tmp_path: Path) -> None:
    answer = rps_bench(
        "shapes", "--references", "exudyn-cable@4", "--modes", "1,4", "--cases", "case2",
        "--output", str(tmp_path),
    )  # fmt: skip
    assert answer.status == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "assurance-case2-exudyn-cable@4.png",
        "assurance-case2-exudyn-cable@4.svg",
        "shapes-case2.png",
    ]
    assert (tmp_path / "shapes-case2.png").stat().st_size > 20_000
