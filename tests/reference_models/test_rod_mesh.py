"""The rod's mesh: volume, second moment, faces, and the element's own functions."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from analytic import InputError
from reference_models.solid.rod_mesh import LOCAL, RodMesh, shape_functions

Array = NDArray[np.float64]

MESHES = [
    RodMesh(0.5, 0.1, along, across, grading)
    for along, across, grading in [(1, 1, 1.0), (4, 1, 3.0), (5, 2, 2.0), (8, 2, 3.0), (3, 3, 1.0)]
]
MESHES += [
    RodMesh(0.5, 0.1, along, across, 2.5, bore)
    for along, across, bore in [(1, 1, 0.07), (5, 2, 0.02), (3, 3, 0.095)]
]


def integrals(mesh: RodMesh) -> tuple[Array, Array, Array]:
    """Points (E, g, 3), volumes (E, g) at 4 x 4 x 4 Gauss points, and smallest det J an element."""
    x, w = leggauss(4)
    at = np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1).reshape(-1, 3)
    weight = np.einsum("i,j,k->ijk", w, w, w).ravel()
    step = 1e-5
    slopes = np.stack(
        [(shape_functions(at + d) - shape_functions(at - d)) / (2 * step) for d in step * np.eye(3)]
    )
    corners = mesh.nodes[mesh.elements]
    jacobian = np.linalg.det(np.einsum("dgn,enx->egdx", slopes, corners))
    return (
        np.einsum("gn,enx->egx", shape_functions(at), corners),
        jacobian * weight,
        jacobian.min(axis=1),
    )


def test_shape_functions() -> None:
    np.testing.assert_allclose(shape_functions(LOCAL.astype(float)), np.eye(20), atol=1e-15)
    at = np.random.default_rng(1).uniform(-1, 1, (50, 3))
    values = shape_functions(at)
    np.testing.assert_allclose(values.sum(axis=1), 1.0, rtol=1e-14)
    # Every quadratic is met exactly, and of the cubics x y z.
    for p in ([1, 0, 0], [0, 2, 0], [1, 1, 0], [0, 1, 1], [1, 1, 1], [2, 1, 0], [0, 0, 2]):
        exact = (at**p).prod(axis=1)
        np.testing.assert_allclose(values @ (LOCAL.astype(float) ** p).prod(axis=1), exact)


@pytest.mark.parametrize("mesh", MESHES, ids=repr)
def test_volume_second_moment_and_no_element_inside_out(mesh: RodMesh) -> None:
    x, volume, jacobian = integrals(mesh)
    assert (jacobian > 0).all()
    area = math.pi * (mesh.diameter**2 - mesh.bore**2) / 4
    second = math.pi * (mesh.diameter**4 - mesh.bore**4) / 64
    assert volume.sum() == pytest.approx(area * mesh.length, rel=1e-9)
    for axis in (0, 1):
        found = (volume * x[..., axis] ** 2).sum() / mesh.length
        assert found == pytest.approx(second, rel=1e-4 if mesh.across == 1 else 1e-6)
    assert (volume * x[..., 2]).sum() == pytest.approx(area * mesh.length**2 / 2, rel=1e-9)
    assert np.abs((volume[..., None] * x).sum(axis=(0, 1))[:2]).max() < 1e-15


@pytest.mark.parametrize("mesh", MESHES, ids=repr)
def test_nodes_are_shared_and_each_used(mesh: RodMesh) -> None:
    section = (8 if mesh.bore else 5) * mesh.across**2
    assert mesh.elements.shape == (mesh.along * section, 20)
    assert np.array_equal(np.unique(mesh.elements), np.arange(len(mesh.nodes)))
    assert len(np.unique(np.round(mesh.nodes, 12), axis=0)) == len(mesh.nodes)
    # Euler's count for a ball of hexahedra: corners - edges + faces - cells = 1; with a hole 0.
    cells = mesh.elements[:, :8]
    edges = {frozenset(c[[a, b]].tolist()) for c in cells for a, b in cell_edges()}
    faces = {frozenset(c[list(face)].tolist()) for c in cells for face in cell_faces()}
    corners = len(np.unique(cells))
    assert corners - len(edges) + len(faces) - len(cells) == (0 if mesh.bore else 1)
    assert corners + len(edges) == len(mesh.nodes)


def cell_edges() -> list[tuple[int, int]]:
    apart = np.abs(LOCAL[:8, None] - LOCAL[None, :8]).sum(axis=2)
    return [(a, b) for a in range(8) for b in range(a) if apart[a, b] == 2]


def cell_faces() -> list[tuple[int, ...]]:
    return [
        tuple(np.flatnonzero(LOCAL[:8, axis] == side).tolist())
        for axis in range(3)
        for side in (-1, 1)
    ]


@pytest.mark.parametrize("mesh", MESHES, ids=repr)
def test_faces_and_centre_line(mesh: RodMesh) -> None:
    # By Euler's formula, corners and edges of (across + 1)^2 + 4 across^2 points, and of a ring.
    n = mesh.across
    face = 24 * n**2 + 16 * n if mesh.bore else 15 * n**2 + 4 * n + 1
    for nodes, z in ((mesh.base, 0.0), (mesh.tip, mesh.length)):
        assert (mesh.nodes[nodes, 2] == z).all()
        x = mesh.nodes[nodes, :2]
        assert np.hypot(*x.T).max() == pytest.approx(mesh.diameter / 2, rel=7e-3)
        assert len(nodes) == face
    fractions = np.linspace(0, 1, 23)
    nodes, weights = mesh.centre_line(fractions)
    line = np.einsum("kn,knx->kx", weights, mesh.nodes[nodes])
    rounding = 1e-14 if mesh.bore else 1e-15  # of a mean over many nodes
    np.testing.assert_allclose(line[:, 2], fractions * mesh.length, rtol=0, atol=rounding)
    assert np.abs(line[:, :2]).max() < 1e-16


def test_refined_twice_the_nodes_stay() -> None:
    coarse, fine = RodMesh(0.5, 0.1, 4, 1, 3.0), RodMesh(0.5, 0.1, 8, 2, 3.0)
    assert np.isin(np.round(coarse.levels, 14), np.round(fine.levels, 14)).all()


def test_grading_crowds_ends_and_rim() -> None:
    graded, even = RodMesh(0.5, 0.1, 8, 2, 3.0), RodMesh(0.5, 0.1, 8, 2)
    steps = np.diff(graded.levels)
    assert steps[0] == pytest.approx(steps[-1]) == pytest.approx(0.25 / 4**3)
    np.testing.assert_allclose(np.diff(even.levels), 0.5 / 8)
    assert integrals(graded)[1].sum(axis=1).min() < 0.1 * integrals(even)[1].sum(axis=1).min()


@pytest.mark.parametrize(
    ("argument", "value"),
    [("length", 0.0), ("diameter", -1), ("along", 0), ("across", 1.5), ("grading", 0.5)],
)
def test_bad_input(argument: str, value: Any) -> None:
    good = {"length": 0.5, "diameter": 0.1, "along": 4, "across": 1}
    with pytest.raises(InputError, match=f"^{argument} = {value}: expected"):
        RodMesh(**(good | {argument: value}))


def test_a_hole_leaves_a_wall() -> None:
    for bore in (-0.01, 0.1, 0.2):
        with pytest.raises(InputError, match="bore"):
            RodMesh(0.5, 0.1, 4, 1, bore=bore)
