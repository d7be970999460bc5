"""Single cubics on nonconvex faces of A-patches: C1, where they are taken, and what their free coefficient is for."""

import numpy as np
import pytest
from trivariate_functions import gradient_jumps, noisy_torus

from testbed.geometry.domain import lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, angle_between, norm
from testbed.registry import dataset
from testbed_datasets.joined_faces import JoinedFaces
from testbed_schemes.a_patch import APatch
from testbed_schemes.mathematics import a_patch_single
from testbed_schemes.mathematics.a_patch_classes import Convexity
from testbed_schemes.mathematics.a_patch_sides import Hull, hull, nets_of_faces
from testbed_schemes.mathematics.a_patch_single import may_be_single, single_cubics

NUMBER3 = [1, 2, 4]
NONE = np.zeros(1, dtype=bool)


def all_points(surface: Surface, steps: int) -> Float:
    return np.concatenate([batch.jets(lattice(batch.sides, steps), 0).f.reshape(-1, 3) for batch in surface.batches])


def test_single_cubics_are_c1_with_free_number_2_coefficients() -> None:
    found = hull(noisy_torus(), 0.05, 1e-12)
    cubics = single_cubics(found)
    assert cubics.single.sum() > 50
    assert cubics.single.sum() + cubics.given_up == may_be_single(found).sum()
    split = (found.faces == Convexity.NONCONVEX) & ~cubics.single
    jumps = gradient_jumps(found, split, cubics.turns)
    assert max(jumps.values()) <= 1e-11
    nets = nets_of_faces(found, 0, split, cubics.turns)
    own = cubics.single[nets.faces]
    # one cubic: no rational term is left, though the three edges ask for one coefficient each
    assert np.abs(nets.rational[own]).max() <= 1e-11
    plain = nets_of_faces(found, 0, split)
    assert np.abs(plain.rational[own]).max() > 1e-3


def test_single_cubics_need_fewer_tetrahedra_and_give_another_surface() -> None:
    three, single = (one.fit(noisy_torus()) for one in (APatch(), APatch(split="single")))
    chosen = single.branches["single cubics"]
    assert chosen > 50
    fewer = three.branches["tetrahedra of faces"] - single.branches["tetrahedra of faces"]
    assert fewer == 4 * chosen  # two each, on both sides
    assert three.patch_count == single.patch_count
    assert norm(all_points(three, 4) - all_points(single, 4)).max() > 1e-3


def test_single_cubics_lift_number_3_coefficients_where_they_can() -> None:
    """One face has three edges to itself: its coefficient is moved until none is negative, or it keeps three cubics."""
    mesh = noisy_torus()
    counts = []
    for face in range(60):
        found = hull(mesh.submesh(np.array([face])), 0.05, 1e-12)
        if found.faces[0] != Convexity.NONCONVEX:
            continue
        cubics = single_cubics(found)
        assert cubics.single[0] == possible(found)
        if cubics.single[0]:
            for side in range(2):
                nets = nets_of_faces(found, side, NONE, cubics.turns)
                assert nets.layer1[:, NUMBER3].min() >= 0.0
                # with the turns of the mean alone some would be negative
                counts.append(number3(found, side, float(mean_number2(found))).min() < 0.0)
        else:
            assert not cubics.turns.any()
            assert cubics.given_up == 1
    assert any(counts)


def possible(found: Hull) -> bool:
    """Whether some number 2 coefficient of a single face leaves no number 3 coefficient negative: they are affine."""
    low, high = -np.inf, np.inf
    zero, one = (np.concatenate([number3(found, side, value) for side in range(2)]) for value in (0.0, 1.0))
    for value, slope in zip(zero, one - zero, strict=True):
        if slope > 0.0:
            low = max(low, -value / slope)
        elif slope < 0.0:
            high = min(high, -value / slope)
    return low <= high


def mean_number2(found: Hull) -> Float:
    """The mean of (4.10) to (4.12)."""
    return np.asarray(nets_of_faces(found, 0, NONE).layer0[0, 0, 4])


def number3(found: Hull, side: int, value: float) -> Float:
    """Number 3 coefficients (3,) of a single face whose number 2 coefficient has this value, by least turns."""
    base, plain = found.mesh.corner_points(), nets_of_faces(found, 0, NONE)
    number2 = plain.rational[0] + plain.layer0[0, 0, 4]
    turns = np.zeros((1, 3, 3))
    for s in range(3):
        p, q, far = base[0, (s + 1) % 3], base[0, (s + 2) % 3], base[0, s]
        across = far - p - (far - p) @ (q - p) / ((q - p) @ (q - p)) * (q - p)
        turns[0, s] = 3.0 * (value - number2[s]) * across / (across @ across)
    return nets_of_faces(found, side, NONE, turns).layer1[0, NUMBER3]


def test_coplanar_neighbours_and_mixed_folds_keep_three_cubics() -> None:
    mesh = JoinedFaces("nonconvex").mesh(0)
    assert may_be_single(hull(mesh, 0.05, 1e-12)).all()
    flat = HermiteMesh(mesh.points * [1, 1, 0], mesh.faces, gradients=mesh.gradients)
    found = hull(flat, 0.05, 1e-12)
    assert (found.faces == Convexity.NONCONVEX).all()
    assert not may_be_single(found).any()
    # two neighbours, one of them folded back over the face
    points = np.array([[0, 0, 0], [2, 0, 0], [1, 2, 0], [1, 1, 1], [3, 1.5, 0.5]], dtype=float)
    faces = np.array([[0, 1, 2], [1, 0, 3], [2, 1, 4]])
    tilted = np.tile([0.3, 0.1, 1.0], (5, 1))
    for chosen, expected in (([0, 1], True), ([0, 2], True), ([0, 1, 2], False)):
        found = hull(HermiteMesh(points, faces, gradients=tilted).submesh(np.array(chosen)), 0.05, 1e-12)
        assert found.faces[0] == Convexity.NONCONVEX
        assert may_be_single(found)[0] == expected


def test_faces_that_keep_three_cubics_would_tear(monkeypatch: pytest.MonkeyPatch) -> None:
    """Next to a pinch with a negative number 3 coefficient rays start on the wrong side and find no first root."""
    mesh = dataset("branch").mesh(0)
    surface = APatch(split="single").fit(mesh)
    assert surface.branches["nonconvex faces that single cubics would tear"] > 0
    assert np.isfinite(all_points(surface, 8)).all()
    edges = surface.edges[surface.edges.interior]
    left, right = surface.edge_jets(edges, np.arange(1, 16) / 16, 1)
    assert norm(left.f - right.f).max() <= 1e-13
    assert angle_between(left.normal, right.normal).max() <= 1e-9

    lifted = a_patch_single._Edges.lifted

    def without_giving_up(edges: a_patch_single._Edges, free: Float) -> tuple[Float, Bool]:
        moved, spoilt = lifted(edges, free)
        return moved, np.zeros_like(spoilt)

    monkeypatch.setattr(a_patch_single._Edges, "lifted", without_giving_up)
    assert np.isnan(all_points(APatch(split="single").fit(mesh), 8)).any()
