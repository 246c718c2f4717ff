"""Random limbs of random chains: all formulations agree, and the counts are right."""

import math

import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st

from analytic import (
    Body,
    Continuum,
    Joint,
    Limb,
    Material,
    Mechanism,
    NotCertifiedError,
    Platform,
    Pose,
    Rod,
    Section,
    Substructure,
)

STEEL = Material(200e9, 77e9, 7820)


def richardson(mechanism: Mechanism, pose: Pose, beam: str, count: int, s: int = 4) -> np.ndarray:
    """Return the limit of s, 2 s and 4 s elements, whose errors go with h^2 and h^4."""
    one, two, four = (
        Substructure(k * s, beam).frequencies(mechanism, pose, count) for k in (1, 2, 4)
    )
    return (16 * (4 * four - two) - (4 * two - one)) / 45


@st.composite
def robots(draw: st.DrawFn) -> tuple[Mechanism, Pose]:
    """Return 6 to 8 limbs of random chains, from millimetres to tens of metres, at a pose."""
    size = 10 ** draw(st.floats(-3, 1.3))
    k = 2e11 * size * draw(st.floats(1e-4, 1e-2))

    def rod(length: float | None) -> Rod:
        d = size * draw(st.floats(0.01, 0.08))
        kind = draw(st.sampled_from(["solid", "tube", "general"]))
        if kind == "general":
            a = d**2 * draw(st.floats(0.3, 0.8))
            ix, iy = (d**4 * draw(st.floats(0.01, 0.05)) for _ in range(2))
            return Rod(STEEL, Section(a, (ix, iy), 0.7 * min(ix, iy), (0.8, 0.7)), length)
        return Rod(STEEL, Section.round(d, d * 0.6 if kind == "tube" else 0.0), length)

    limbs = []
    for i in range(draw(st.integers(6, 8))):
        angle = i * math.pi / 3 + draw(st.floats(-0.2, 0.2))
        out = np.array([math.cos(angle), math.sin(angle), 0.0])
        tangent = (-out[1], out[0], draw(st.floats(-0.3, 0.3)))
        first = draw(st.sampled_from(["U", "S", "flexure", "fixed"]))
        start = {
            "U": (Joint.universal(tangent),),
            "S": (Joint.spherical(),),
            "flexure": (Joint.spherical(k * size**2 * 1e-4),),
            "fixed": (),
        }[first]
        drive = (Joint.prismatic(stiffness=k),) if draw(st.booleans()) else ()
        if draw(st.booleans()):
            m = 7820 * size**3 * 1e-4
            body = Body(
                m, tuple(np.diag([m * size**2 * 1e-3] * 3).tolist()), (0, 0, 0.01 * size), "limb"
            )
            drive = (*drive, body)
        chain = (*start, rod(0.4 * size), *drive, rod(None), Joint.spherical())
        at = 0.65 * math.pi / 3 * (-1) ** i + angle
        point = 0.5 * size * np.array([math.cos(at), math.sin(at), 0.0])
        limbs.append(Limb(tuple(size * out), tuple(point), chain))
    m = 7820 * size**3 * draw(st.floats(1e-3, 1e-2))
    plate = Platform.diagonal(m, (m * size**2 * 0.1, m * size**2 * 0.12, m * size**2 * 0.15))
    turn = Pose(0, draw(st.floats(-3, 3)), draw(st.floats(-0.2, 0.2)), draw(st.floats(-0.2, 0.2)))
    x, y = (size * draw(st.floats(-0.1, 0.1)) for _ in range(2))
    return Mechanism(tuple(limbs), plate), Pose.at(
        (x, y, size * draw(st.floats(0.9, 1.3))), turn.rotation
    )


@pytest.mark.slow
@settings(max_examples=6)
@given(robots(), st.sampled_from(["euler-bernoulli", "rayleigh", "timoshenko"]))
def test_random_chains_agree_in_all_formulations(robot: tuple[Mechanism, Pose], beam: str) -> None:
    mechanism, pose = robot
    model = Continuum(beam)
    try:
        found = model.modes(mechanism, pose, 8).frequencies
    except NotCertifiedError:  # soft motions of slender limbs beside stiff ones: said, not guessed
        reject()
    # Elements bound frequencies from above, and their limit is the continuum.
    coarse = Substructure(2, beam).frequencies(mechanism, pose, 8)
    assert (coarse >= found * (1 - 1e-8)).all()
    assert richardson(mechanism, pose, beam, 8) == pytest.approx(found, rel=1e-6)
    last = float(found[-1])
    assert model.count_below(mechanism, pose, last * (1 + 1e-7)) >= 8
    assert model.count_below(mechanism, pose, float(found[0]) * (1 - 1e-7)) == 0
    brackets = model.brackets(mechanism, pose, 8)
    assert (brackets[:, 0] <= found).all()
    assert (found <= brackets[:, 1]).all()
    assert (brackets[:, 1] / brackets[:, 0] - 1).max() < 1e-8
