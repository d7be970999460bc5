"""Classes of edges and faces: the four kinds, what zeros mean, the paper's examples, and what reversal does to them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.geometry.vectors import Float
from testbed_datasets.joined_faces import Case, JoinedFaces
from testbed_schemes.mathematics.a_patch_classes import Convexity, edge_convexity, face_convexity
from testbed_schemes.mathematics.a_patch_sides import hull

ZERO, POSITIVE, NEGATIVE, NONCONVEX = Convexity.ZERO, Convexity.POSITIVE, Convexity.NEGATIVE, Convexity.NONCONVEX
ALONG = np.array([[2.0, 0.0, 0.0]])


def classified(a: float, b: float, tolerance: float = 1e-12) -> int:
    """Class of the edge from the origin to (2, 0, 0) whose vectors rise by A / 2 and B / 2 in the middle of it."""
    at_start, at_end = np.array([[-b / 2.0, 0.0, 1.0]]), np.array([[a / 2.0, 0.0, 1.0]])
    return int(edge_convexity((np.zeros((1, 3)), ALONG), (at_start, at_end), tolerance)[0])


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        (0.0, 0.0, ZERO),
        (1.0, 2.0, POSITIVE),
        (-1.0, -2.0, NEGATIVE),
        (1.0, -2.0, NONCONVEX),
        (-1e-9, 2.0, NONCONVEX),
        # one of them zero: convex, however small the other
        (0.0, 2.0, POSITIVE),
        (0.0, -1e-9, NEGATIVE),
        (3.0, 0.0, POSITIVE),
        # within the tolerance
        (1e-13, -2.0, NEGATIVE),
        (-1e-13, 1e-13, ZERO),
    ],
)
def test_edges_are_classified_by_two_signs(a: float, b: float, expected: Convexity) -> None:
    assert classified(a, b) == expected


def test_the_tolerance_is_relative_to_edge_and_vector() -> None:
    assert classified(1e-4, -1.0) == NONCONVEX
    assert classified(1e-4, -1.0, tolerance=1e-3) == NEGATIVE
    large = (np.zeros((1, 3)), 1e6 * ALONG), (np.array([[0.5, 0.0, 1.0]]), np.array([[5e-14, 0.0, 1.0]]))
    assert edge_convexity(*large, 1e-12)[0] == NEGATIVE


@pytest.mark.parametrize(
    ("edges", "expected"),
    [
        ((0, 0, 0), ZERO),
        ((1, 0, 0), POSITIVE),
        ((1, 1, 1), POSITIVE),
        ((2, 0, 2), NEGATIVE),
        ((1, 2, 0), NONCONVEX),
        ((3, 0, 0), NONCONVEX),
        ((3, 1, 1), NONCONVEX),
    ],
)
def test_faces_are_classified_by_their_edges(edges: tuple[int, int, int], expected: Convexity) -> None:
    assert face_convexity(np.array([edges]))[0] == expected


@pytest.mark.parametrize(
    ("case", "faces", "edges"),
    [
        ("convex", (POSITIVE, POSITIVE), {"01": POSITIVE, "02": POSITIVE, "12": POSITIVE}),
        # n_3 = n_4 = (0, 1, 1.5) as printed give a convex and a nonconvex face, as the text says
        ("mixed", (POSITIVE, NONCONVEX), {"01": POSITIVE, "03": NONCONVEX, "13": NONCONVEX}),
        (
            "nonconvex",
            (NONCONVEX, NONCONVEX),
            {"01": NONCONVEX, "12": NONCONVEX, "02": NEGATIVE, "03": NEGATIVE, "13": NONCONVEX},
        ),
        ("flat", (NONCONVEX, ZERO), {"01": ZERO, "03": ZERO, "13": ZERO}),
    ],
)
def test_the_papers_examples_are_of_the_classes_it_names(
    case: Case, faces: tuple[Convexity, ...], edges: dict[str, Convexity]
) -> None:
    found = hull(JoinedFaces(case).mesh(0), 0.05, 1e-12)
    assert tuple(found.faces) == faces
    by_ends = {f"{i}{j}": kind for (i, j), kind in zip(found.mesh.edges.tolist(), found.edges, strict=True)}
    assert {ends: by_ends[ends] for ends in edges} == edges


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=50, deadline=None)
def test_reversed_vectors_exchange_positive_and_negative(seed: int) -> None:
    rng = np.random.default_rng(seed)
    ends = rng.normal(size=(2, 40, 3))
    vectors: Float = rng.normal(size=(2, 40, 3))
    found = edge_convexity((ends[0], ends[1]), (vectors[0], vectors[1]), 1e-12)
    other = edge_convexity((ends[0], ends[1]), (-vectors[0], -vectors[1]), 1e-12)
    assert np.array_equal(other, np.array([ZERO, NEGATIVE, POSITIVE, NONCONVEX])[found])
    back = edge_convexity((ends[1], ends[0]), (vectors[1], vectors[0]), 1e-12)
    assert np.array_equal(back, found)
    faces = found[: 39 // 3 * 3].reshape(-1, 3)
    swapped = np.array([ZERO, NEGATIVE, POSITIVE, NONCONVEX])
    assert np.array_equal(face_convexity(swapped[faces]), swapped[face_convexity(faces)])
