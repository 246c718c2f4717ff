"""The parts of the error add up, and each is what its name says."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analytic import Continuum, Substructure
from harness.budget import budget
from harness.cases import PRESETS
from harness.models import Spec

REFERENCE = Spec("exudyn-beam", (12, 24))


@pytest.mark.parametrize("theory", ["euler-bernoulli", "rayleigh", "timoshenko"])
def test_parts_add_up_to_the_error(theory: str) -> None:
    case = PRESETS["case2"]  # eigen-solutions round to 1e-10: 1e-8 points
    result = budget([case], Spec(theory, 3), [1, 3], REFERENCE, 6)
    fea = REFERENCE.build().modes(case.mechanism, case.pose).frequencies
    for s, table in zip((1, 3), result.shares["case2"], strict=True):
        ours = Substructure(s, theory).modes(case.mechanism, case.pose).frequencies
        np.testing.assert_allclose(table.sum(axis=0), 100 * (ours / fea - 1), atol=1e-7)
        exact = Continuum(theory).modes(case.mechanism, case.pose).frequencies
        np.testing.assert_allclose(table[0], 100 * (ours - exact) / fea, atol=1e-7)
    beams = {"euler-bernoulli": 2, "rayleigh": 1, "timoshenko": 0}
    assert len(result.parts) == 2 + beams[theory]


def test_effects_have_their_sign_and_size() -> None:
    """Rotary inertia and shear both lower every frequency; at s = 3 they are nearly all of it."""
    result = budget([PRESETS["case1"]], Spec("euler-bernoulli", 3), [3], REFERENCE, 6)
    elements, inertia, shear, rest = result.shares["case1"][0]
    assert (inertia > 0.25).all() and (shear > 1).all() and (elements > 0).all()
    assert (elements < 0.1).all() and (np.abs(rest) < 0.005).all()
    assert (np.abs(rest) < result.uncertainty["case1"][REFERENCE.label]).all()


@pytest.mark.slow
def test_solids_part_three_dimensional_effects_from_end_faces() -> None:
    """Faces that may warp leave beam theory right to 0.1 %; holding them rigid stiffens f1-f3."""
    solid = Spec("calculix-solid", (4, 8))
    result = budget([PRESETS["case1"]], Spec("timoshenko", 3), [3], solid, 6)
    assert result.parts[1:] == ("three-dimensional effects", "rigid end faces")
    _, effects, faces = result.shares["case1"][0]
    assert (np.abs(effects) < 0.15).all()
    assert (faces[:3] < -0.5).all() and (np.abs(faces[3:]) < 0.2).all()
    assert list(result.uncertainty["case1"]) == ["ngsolve-averaged@2+4", solid.label]
    fea = solid.build().modes(PRESETS["case1"].mechanism, PRESETS["case1"].pose).frequencies
    ours = Substructure(3, "timoshenko").modes(PRESETS["case1"].mechanism, PRESETS["case1"].pose)
    total = result.shares["case1"][0].sum(axis=0)
    np.testing.assert_allclose(total, 100 * (ours.frequencies / fea - 1), atol=1e-7)


def test_command(rps_bench: Callable[..., Any], tmp_path: Path) -> None:
    answer = rps_bench(
        "budget", "--references", "exudyn-cable@4", "--elements", "1,3", "--modes", "1-3",
        "--output", str(tmp_path),
    )  # fmt: skip
    assert answer.status == 0
    assert "not known" in answer.out  # one mesh gives no uncertainty
    assert {path.name for path in tmp_path.iterdir()} == {
        *(f"budget.{form}" for form in ("csv", "md", "tex", "svg", "png")),
        "floor.svg", "floor.png",
    }  # fmt: skip
