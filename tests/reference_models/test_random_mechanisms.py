"""Random mechanisms of R-P-S limbs: every simulator meets the limit of its theory, or refuses."""

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from analytic import InputError, Material, Mechanism, Platform, Pose, Rod
from reference_models import ModelError, UnavailableError, reference

STEEL = Material(200e9, 77e9, 7820.0)


@st.composite
def mechanisms(draw: Any) -> tuple[Mechanism, Pose]:
    """1 to 12 limbs, equal or not, of millimetres to kilometres, platforms light to heavy."""
    size = 10 ** draw(st.floats(-3, 3))
    r1, r2 = size * draw(st.floats(0.2, 0.5)), size * draw(st.floats(0.1, 0.4))
    rod = Rod.round(STEEL, size * draw(st.floats(0.02, 0.08)))
    weight = 10 ** draw(st.floats(-1, 2))
    platform = Platform.disc(r2, 0.1 * r2, weight * STEEL.density)
    limbs = draw(st.integers(1, 12))
    found = Mechanism.regular(r1, r2, rod, platform, limbs=limbs, heading=draw(st.floats(0, 3)))
    if draw(st.booleans()):  # one limb of another rod
        other = found.limbs[0].with_rod(Rod.round(STEEL, 1.3 * rod.diameter))
        found = Mechanism((other, *found.limbs[1:]), platform)
    return found, Pose(size * draw(st.floats(0.5, 0.8)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "elements"),
    [("exudyn-beam", (8, 16)), ("exudyn-cable", (4, 8)), ("mujoco-cable", (8, 16)),
     ("mujoco-chain", (8, 16))],
)  # fmt: skip
def test_simulators_meet_their_limit_or_refuse(name: str, elements: Any) -> None:
    try:
        model = reference(name, elements)
    except UnavailableError as reason:
        pytest.skip(str(reason))
    answered = 0

    @settings(max_examples=12, database=None, derandomize=True,
              suppress_health_check=list(HealthCheck))  # fmt: skip
    @given(mechanisms())
    def check(drawn: tuple[Mechanism, Pose]) -> None:
        nonlocal answered
        mechanism, pose = drawn
        exact = model.limit().modes(mechanism, pose, 12).frequencies
        try:
            found = model.modes(mechanism, pose, 6).frequencies
        except (InputError, ModelError) as error:
            assert str(error)
            return
        answered += 1
        still = int((exact == 0).sum())
        if not model.info().torsion:  # its rods do not twist
            exact = np.array([f for f in exact if np.abs(found / max(f, 1e-300) - 1).min() < 0.02])
        moving = exact[exact > 0]
        free = int((found < 1e-3 * moving[0]).sum())
        assert free == min(still, 6)
        low = found[free:]
        np.testing.assert_allclose(low, moving[: len(low)], rtol=0.01)

    check()
    assert answered >= 6
