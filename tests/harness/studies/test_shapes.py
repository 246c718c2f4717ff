"""Mode shapes beside each other: same order, same sign, same basis; and their pictures."""

from pathlib import Path

import numpy as np
import pytest

from harness.bench import Study, run
from harness.case_file import load_cases
from harness.cases import PRESETS
from harness.drawing import AMPLITUDE, drawn, scale, tube
from harness.figures import picture
from harness.studies.shapes import Shapes, aligned
from reference_models import Named

MECHANISMS = Path(__file__).parents[3] / "results/published/mechanisms.toml"
THEORY, REFERENCE = Named("euler-bernoulli", 6), Named("exudyn-cable", 6)


@pytest.fixture(scope="module")
def study() -> Study:
    return run([PRESETS["case1"], PRESETS["case2"]], [THEORY, REFERENCE], 6)


@pytest.mark.parametrize("name", ["case1", "case2"])
def test_a_reference_is_turned_to_the_theory(study: Study, name: str) -> None:
    """Also the repeated pairs of case 1, whose basis either model is free to choose."""
    case = PRESETS[name]
    ours, theirs = study.first(case, THEORY), aligned(study, case, THEORY, REFERENCE)
    assert ours is not None and theirs is not None
    size = np.abs(ours.limbs).max(axis=(1, 2, 3))
    off = np.abs(theirs.limbs - ours.limbs).max(axis=(1, 2, 3)) / size
    assert off.max() < 2e-3
    largest = np.abs(ours.platform).max()
    np.testing.assert_allclose(theirs.platform, ours.platform, atol=2e-3 * largest)
    np.testing.assert_allclose(theirs.frequencies, ours.frequencies, rtol=1e-5)


def test_a_tube_has_its_radius() -> None:
    line = np.linspace([0.0, 0, 0], [0, 0, 1], 5)
    surface = tube(line, 0.05)
    around, ends = surface[1:-1], surface[[0, -1]]
    np.testing.assert_allclose(np.hypot(around[..., 0], around[..., 1]), 0.05)
    np.testing.assert_allclose(around[..., 2], np.broadcast_to(line[:, 2:], (5, 33)))
    np.testing.assert_allclose(ends, np.broadcast_to(line[[0, -1], None], (2, 33, 3)), atol=1e-15)


def test_rods_end_on_the_rim_of_the_platform(study: Study) -> None:
    """At rest and moved: the joints stay closed in the picture too."""
    case = PRESETS["case2"]
    there, modes = drawn(case.mechanism, case.pose), study.answers[case, THEORY].first(6)
    arms = there.tips - there.centre
    np.testing.assert_allclose(np.linalg.norm(arms, axis=1), there.radius)
    size = scale(there, modes.limbs)
    largest = np.abs(size[:, None, None, None] * modes.limbs).max(axis=(1, 2, 3))
    np.testing.assert_allclose(largest, AMPLITUDE * there.length)
    for i, factor in enumerate(size):
        shift, spin = factor * modes.platform[i, :3], factor * modes.platform[i, 3:]
        ends = there.limbs(factor * modes.limbs[i])[:, -1]
        moved = there.centre + shift + arms + np.cross(spin, arms)
        np.testing.assert_allclose(ends, moved, atol=1e-9)


def test_a_chain_is_drawn_item_by_item() -> None:
    """Both links with their own diameters, every joint where it is, and the centre of mass."""
    case = load_cases(MECHANISMS)["hexapod"]
    there = drawn(case.mechanism, case.pose)
    assert [one.radius for one in there.spans] == pytest.approx(6 * [0.035, 0.02])
    lengths = np.linalg.norm(there.tips - there.starts, axis=1)
    first = [one.end * lengths[one.limb] for one in there.spans[::2]]
    assert first == pytest.approx(6 * [0.42])
    assert [one.kind for one in there.marks] == 6 * ["U", "P", "S"]
    places = there.marked(there.limbs()).reshape(6, 3, 3)
    np.testing.assert_allclose(places[:, 0], case.mechanism.bases, atol=1e-12)
    np.testing.assert_allclose(places[:, 2], there.tips, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(places[:, 1] - places[:, 0], axis=1), 0.42)
    np.testing.assert_allclose(there.mass - there.centre, case.pose.rotation @ [0, 0, 0.02])
    x, y, _ = there.ground.T
    turns = np.diff(np.unwrap(np.arctan2(y, x)))
    assert (turns > 0).all() and turns.sum() == pytest.approx(2 * np.pi)


def test_a_slider_is_drawn_on_its_rail() -> None:
    case = load_cases(MECHANISMS)["prs"]
    there = drawn(case.mechanism, case.pose)
    np.testing.assert_allclose((there.starts - there.bases)[:, :2], 0, atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(there.tips - there.starts, axis=1), 0.55)
    kinds = {one.kind: one for one in there.marks if one.limb == 0}
    assert list(kinds) == ["P", "body", "R", "S"]
    np.testing.assert_allclose(kinds["body"].beside, [0, 0, 0.015])


def test_assurance_of_every_pair_and_a_picture_a_case(study: Study) -> None:
    result = Shapes(study, THEORY, (REFERENCE,), (1, 4))
    frame = result.to_frame()
    assert len(frame) == 2 * 2 * 8  # cases, modes shown, modes of the reference
    assert (frame[frame["partner"]]["assurance"] > 0.999).all()
    assert frame.groupby(["case", "mode"])["partner"].sum().eq(1).all()
    figures = result.figures()
    assert list(figures) == ["-case1", "-case2", "-assurance-case1-exudyn-cable@6",
                             "-assurance-case2-exudyn-cable@6"]  # fmt: skip
    title = " ".join(figures["-case2"].get_suptitle().split())
    assert "drawn as 0.2 of the mean limb length" in title
    assert len(picture(figures["-case2"], "png")) > 20_000
