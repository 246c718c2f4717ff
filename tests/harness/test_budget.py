"""The parts of the error add up, and each is what its name says."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analytic import Continuum, Substructure
from analytic.pairing import pair
from harness.budget import budget
from harness.cases import PRESETS
from harness.models import Spec
from harness.refinement import ladder, refine

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


def test_the_references_own_is_the_gci_of_its_three_meshes() -> None:
    """As `rps-bench refine` has it, whose modes are in the reference's own order."""
    case = PRESETS["case2"]
    result = budget([case], Spec("euler-bernoulli", 3), [3], REFERENCE, 6)
    steps = ladder(REFERENCE, None)
    assert [spec.elements for spec in steps] == [6, 12, 24]
    found = refine([case], [steps], 6).found
    model = Substructure(3).modes(case.mechanism, case.pose)
    partner = pair(model, steps[-1].build().modes(case.mechanism, case.pose, 8),
                   case.mechanism, case.pose).partner  # fmt: skip
    for i, own in enumerate(result.uncertainty["case2"][REFERENCE.label]):
        values, seen = found["case2", REFERENCE.name, int(partner[i])]
        assert own == pytest.approx(100 * seen.gci / values[-1], rel=1e-6)
        # In the asymptotic range: 1.25 times the observed step to the limit, not the step itself.
        assert own == pytest.approx(125 * abs(seen.limit / values[-1] - 1), rel=1e-6)


def test_a_warning_of_the_meshes_is_a_note() -> None:
    """MuJoCo's chain converges faster in f4 than its order says; a single mesh has no band."""
    chain = Spec("mujoco-chain", (12, 24))
    case = PRESETS["case1"]
    result = budget([case], Spec("euler-bernoulli", 3), [3], chain, 6)
    seen = refine([case], [ladder(chain, None)], 6).found
    warned = [found.remark for _, found in seen.values() if found.remark]
    said = [note for note in result.notes if note.startswith("case1: GCI of mujoco-chain@12+24")]
    assert warned and len(said) == len(set(warned))
    assert all(any(remark in note for note in said) for remark in warned)
    # One mesh, none, and two of which the coarser cannot be halved.
    for single in (Spec("exudyn-cable", 4), Spec("timoshenko", None), Spec("mujoco-chain", (2, 4))):
        own = budget([case], Spec("euler-bernoulli", 3), [3], single, 6).uncertainty["case1"]
        assert np.isnan(own[single.label]).all()


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
