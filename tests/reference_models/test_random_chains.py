"""Limbs of random chains: MuJoCo, Exudyn and CalculiX against the exact model of each theory."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analytic import (
    Body,
    Continuum,
    Freedom,
    Joint,
    Limb,
    Link,
    Material,
    Mechanism,
    Platform,
    Pose,
    Rod,
    Section,
)
from analytic.mechanism import Item
from reference_models import UnavailableError, reference

MATERIALS = Material(200e9, 77e9, 7820.0), Material(70e9, 26e9, 2700.0)


class Chance:
    """Makes mechanisms of three to six limbs, all from one seed; `flat`: with bars too."""

    def __init__(self, seed: int, *, flat: bool) -> None:
        self.rng, self.flat = np.random.default_rng(seed), flat

    def one_in(self, n: int) -> bool:
        return bool(self.rng.integers(n) == 0)

    def stiffness(self, kind: str) -> float:
        return float(10 ** self.rng.uniform(*((4, 6) if kind == "rotation" else (6.5, 8.5))))

    def tensor(self, size: float) -> Any:
        axes = Rotation.random(rng=self.rng).as_matrix()
        J = axes @ np.diag(self.rng.uniform(1, 1.5, 3) * size) @ axes.T
        return tuple(map(tuple, ((J + J.T) / 2).tolist()))

    def rod(self, length: float | None = None) -> Rod:
        material = MATERIALS[self.rng.integers(2)]
        if self.flat and self.one_in(2):
            a, b = self.rng.uniform(0.02, 0.05, 2)
            moments, J = (a * b**3 / 12, b * a**3 / 12), 0.14 * min(a, b) ** 3 * max(a, b)
            return Rod(material, Section(a * b, moments, J, (0.83, 0.85)), length)
        d = self.rng.uniform(0.02, 0.05)
        return Rod(material, Section.round(d, 0.7 * d if self.one_in(2) else 0.0), length)

    def joint(self, kinds: str, frame: str) -> Joint:
        kind = self.rng.choice(list(kinds))
        if kind == "U":
            return Joint.universal(tuple(self.rng.normal(size=3)), frame)
        if kind == "S":
            return Joint.spherical(self.stiffness("rotation") if self.one_in(3) else 0.0)
        if kind == "0":
            return Joint(())
        axes = [tuple(axis) for axis in Rotation.random(rng=self.rng).as_matrix()]
        turns, shifts = axes[: self.rng.integers(1, 4)], axes[: self.rng.integers(0, 3)]
        of = [("rotation", axis) for axis in turns] + [("translation", axis) for axis in shifts]
        return Joint(tuple(Freedom(k, axis, frame, self.stiffness(k)) for k, axis in of))

    def limb(self, angle: float) -> Limb:
        chain: list[Item] = [self.joint("SU0F", "base")]
        if self.one_in(3):
            chain.append(Link(0.05))
        if not self.one_in(3):
            chain.append(self.rod(0.25))
            if self.one_in(2):
                centre = tuple(0.02 * self.rng.normal(size=3))
                frame = str(self.rng.choice(["base", "limb"]))
                chain.append(Body(2.0, self.tensor(0.01), centre, frame))
            if not self.one_in(3):
                chain.append(Joint.prismatic(None, self.stiffness("translation")))
        chain.append(self.rod())
        if self.one_in(3):
            chain.append(Link(0.05))
        chain.append(self.joint("SSF0", str(self.rng.choice(["base", "platform", "limb"]))))
        b, p = angle + self.rng.uniform(-0.3, 0.3), angle + self.rng.uniform(-0.8, 0.8)
        base = (0.6 * np.cos(b), 0.6 * np.sin(b), self.rng.uniform(-0.1, 0.1))
        point = (0.35 * np.cos(p), 0.35 * np.sin(p), self.rng.uniform(-0.05, 0.05))
        return Limb(base, point, tuple(chain))

    def mechanism(self) -> tuple[Mechanism, Pose]:
        n = int(self.rng.integers(3, 7))
        limbs = tuple(self.limb(2 * np.pi * i / n) for i in range(n))
        centre = tuple(0.03 * self.rng.normal(size=3))
        platform = Platform(30.0, self.tensor(1.0), "given", centre)
        R = Rotation.from_rotvec(0.15 * self.rng.normal(size=3)).as_matrix()
        return Mechanism(limbs, platform), Pose.at([0.05, -0.03, 0.75], R)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(
    ("name", "elements", "error"),
    [("mujoco-chain", (8, 16), 3e-4), ("exudyn-beam", (12, 24), 3e-4), ("calculix-solid", 4, 0.05)],
)
def test_random_chains(name: str, elements: Any, error: float, seed: int) -> None:
    """Extrapolated beams leave h^4; coarse solids and rigid faces some per cent."""
    try:
        model = reference(name, elements)
    except UnavailableError as reason:
        pytest.skip(str(reason))
    mechanism, pose = Chance(seed, flat=name != "calculix-solid").mechanism()
    found = model.modes(mechanism, pose, 6).frequencies
    exact = (model.limit() or Continuum("timoshenko")).modes(mechanism, pose, 6).frequencies
    np.testing.assert_allclose(found, exact, rtol=error)
