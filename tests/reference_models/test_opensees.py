"""Frames of OpenSees, in an environment of its own, are the same frames."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analytic import Mechanism, Platform, Pose, Substructure
from reference_models import ModelError, UnavailableError
from reference_models.opensees import peer

MECHANISM, POSE = Mechanism.paper(), Pose(0.49, 0.3, -0.2)


def _made() -> bool:
    try:
        peer.python()
    except UnavailableError:
        return False
    return True


@pytest.mark.skipif(not _made(), reason="python -m reference_models.opensees.peer was not run")
def test_its_frequencies_are_ours() -> None:
    """To 2e-6: its joints are springs of 1e7 times the rods' stiffness, which leaves rounding."""
    pair = np.eye(4), np.eye(4)
    for s in (1, 3):
        own = Substructure(s).frequencies(MECHANISM, POSE)
        for found in peer.timed(MECHANISM, POSE, s, 6, 2, pair):
            np.testing.assert_allclose(found.frequencies, own, rtol=2e-6)
            assert len(found.build) == len(found.solve) == len(found.eigh) == 2


def test_without_its_environment_it_says_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with pytest.raises(UnavailableError, match=r"python -m reference_models\.opensees\.peer"):
        peer.timed(MECHANISM, POSE, 3, 6, 1, (np.eye(2), np.eye(2)))


def test_a_platform_of_other_axes_is_refused() -> None:
    skew = ((0.3, 0.1, 0.0), (0.1, 0.4, 0.0), (0.0, 0.0, 0.5))
    other = replace(MECHANISM, platform=Platform(mass=10.0, inertia=skew))
    with pytest.raises(ModelError, match="diagonal"):
        peer.problem_of(other, POSE)
