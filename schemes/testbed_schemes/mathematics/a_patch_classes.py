"""Classes of edges and faces of A-patches (Xu, Huang and Bajaj 2001, section 3), by the vectors at the vertices.

An edge p_i p_j with A = (p_j - p_i) . n_j and B = (p_i - p_j) . n_i is

    zero convex      A = B = 0
    positive convex  A, B >= 0, not both zero: F <= 0 on the edge, and the surface stands above it
    negative convex  A, B <= 0, not both zero
    nonconvex        A B < 0: the surface crosses the edge between its ends

and a face is zero, positive or negative convex if its edges are so or zero convex, nonconvex otherwise.

Formulas: as printed; **fill**: A and B count as zero up to a tolerance, relative to edge and vector.
"""

from enum import IntEnum

import numpy as np

from testbed.geometry.vectors import Float, Int, dot, norm


class Convexity(IntEnum):
    """Class of an edge or a face."""

    ZERO = 0
    POSITIVE = 1
    NEGATIVE = 2
    NONCONVEX = 3


def edge_convexity(ends: tuple[Float, Float], vectors: tuple[Float, Float], tolerance: float) -> Int:
    """Return the classes (E,) of edges.

    Parameters
    ----------
    ends, vectors
        p_i, p_j and n_i, n_j, (E, 3) each.
    tolerance
        |A| counts as zero up to tolerance * |p_j - p_i| * |n_j|.
    """
    (p, q), (n_p, n_q) = ends, vectors
    along = q - p
    length = norm(along)

    def sign(rise: Float, vector: Float) -> Int:
        signs: Int = np.where(np.abs(rise) <= tolerance * length * norm(vector), 0.0, np.sign(rise)).astype(np.int64)
        return signs

    a, b = sign(dot(along, n_q), n_q), sign(-dot(along, n_p), n_p)
    found = np.where(a + b > 0, Convexity.POSITIVE, np.where(a + b < 0, Convexity.NEGATIVE, Convexity.ZERO))
    return np.where(a * b < 0, Convexity.NONCONVEX, found).astype(np.int64, copy=False)


def face_convexity(edges: Int) -> Int:
    """Return the classes (F,) of faces from those of their edges (F, 3)."""
    positive = ((edges == Convexity.POSITIVE) | (edges == Convexity.ZERO)).all(axis=1)
    negative = ((edges == Convexity.NEGATIVE) | (edges == Convexity.ZERO)).all(axis=1)
    found = np.where(positive, Convexity.POSITIVE, np.where(negative, Convexity.NEGATIVE, Convexity.NONCONVEX))
    return np.where(positive & negative, Convexity.ZERO, found).astype(np.int64, copy=False)
