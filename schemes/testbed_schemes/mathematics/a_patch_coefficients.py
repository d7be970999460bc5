"""Coefficients of A-patches' function F over the tetrahedra of faces (Xu, Huang and Bajaj 2001, steps 1 to 5 and 8).

A tetrahedron stands on a face: corners p_0 p_1 p_2 in the mesh's order, and the apex. F is a cubic in Bernstein-Bezier
form there, plus a rational term, (4.1); or, on a nonconvex face, three cubics, each with the centre c in place of one
corner. Coefficients are named by the points they stand for: F(a, b, c) is the value of F's polar form, so that
F(i, i, u) is the coefficient at p_i towards the apex, F(i, j, u) the one of the triangle p_i p_j u. Edge s of a face is
opposite corner s, from corner i = s + 1 to corner j = s + 2. *Layer* l holds the coefficients with l times the apex,
a triangular net of degree 3 - l in the order of :mod:`testbed.geometry.bernstein`.

Everything is said for the positive side, where F grows along the given vectors. The negative side is the same with the
vectors reversed, and F negated at the end (step 10).

Formulas: as printed in the paper, but

* **corrected**: the third formula of step 4 prints f2100 for f2010; (4.16) prints the sum 3 for 2; (4.12) is garbled;
  for split faces (4.10) needs f1200 and f1020 of the small tetrahedron, too, not only its alpha.
* **fill**: the layers of split faces. Layer 0 is Clough-Tocher's; the others subdivide those of the unsplit face, whose
  number 2 coefficient is the mean of (4.10) to (4.12): C1 inside the face, and quadrics are kept.
"""

from dataclasses import dataclass, fields

import numpy as np

from testbed.geometry.bernstein import index_of, multi_indices
from testbed.geometry.simplex_bernstein import simplex_places
from testbed.geometry.vectors import Bool, Float, Int, dot
from testbed_schemes.mathematics.split_domain import J, K


def _place(*corners: int) -> int:
    """Place, in a triangular net, of the coefficient that stands for these corners."""
    i, j, k = (corners.count(corner) for corner in range(3))
    return index_of((i, j, k))


#: Places of the layers' ordinates among the twenty coefficients of a cubic over a tetrahedron.
LAYER_PLACES: tuple[Int, ...] = tuple(
    simplex_places(np.column_stack([multi_indices(3 - layer), np.full(len(multi_indices(3 - layer)), layer)]))
    for layer in range(4)
)


@dataclass(frozen=True, slots=True)
class FacePieces:
    """Tetrahedra on which F is one formula: R of them, one a face, three a split face.

    Attributes
    ----------
    owner
        (R,) rows of the :class:`FaceNets` they belong to, in order.
    corner
        (R,) the corner that the centre stands for, in place of the face's own; -1 for whole faces.
    base
        (R, 3, 3) the base triangle, the centre in its corner's place.
    layer0, layer1
        (R, 10), (R, 6) ordinates of these layers on the base; the rational term is not in layer 0.
    rational
        (R, 3) coefficients of (4.1): number s multiplies the product of the two barycentric coordinates other than s.
    q
        (R, 3): layer 2 is (f0003 + 2 q) / 3, (4.14).
    """

    owner: Int
    corner: Int
    base: Float
    layer0: Float
    rational: Float
    layer1: Float
    q: Float

    def nets(self, top: Float) -> Float:
        """Return the coefficients (R, 20) over [base, apex], with f0003 = ``top`` (R,), the rational term left out."""
        net = np.empty((len(self.owner), 20))
        layers = (self.layer0, self.layer1, (top[:, None] + 2.0 * self.q) / 3.0, top[:, None])
        for places, layer in zip(LAYER_PLACES, layers, strict=True):
            net[:, places] = layer
        return net


@dataclass(frozen=True, slots=True)
class FaceNets:
    """F over the tetrahedra of N faces on one side, up to the free coefficient f0003.

    Attributes
    ----------
    faces
        (N,) mesh faces.
    base, vectors
        (N, 3, 3) corners and given vectors there, in the frame of the side.
    apex
        (N, 3).
    split
        (N,) true where F is three cubics.
    layer0
        (N, 3, 10) ordinates of layer 0; of split faces, of sub-triangle s with the centre in place of corner s; of
        others three times the same.
    rational
        (N, 3) as in :class:`FacePieces`; zero for split faces.
    layer1
        (N, 6) ordinates of layer 1 on the whole face: numbers 1 and 3.
    q
        (N, 3): layer 2, numbers 4, on the whole face is (f0003 + 2 q) / 3.
    default
        (N,) the paper's choice of f0003, step 8.
    """

    faces: Int
    base: Float
    vectors: Float
    apex: Float
    split: Bool
    layer0: Float
    rational: Float
    layer1: Float
    q: Float
    default: Float

    def __len__(self) -> int:
        return len(self.faces)

    def take(self, rows: Int) -> "FaceNets":
        """Return some of the faces."""
        return FaceNets(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})

    def rows(self, face_count: int) -> Int:
        """Return the row (F,) of every face of the mesh, -1 where it has no tetrahedron on this side."""
        result = np.full(face_count, -1, dtype=np.int64)
        result[self.faces] = np.arange(len(self.faces))
        return result

    def pieces(self) -> FacePieces:
        """Return the tetrahedra with one formula each: whole faces, and thirds of split ones."""
        owner = np.repeat(np.arange(len(self)), np.where(self.split, 3, 1))
        starts = np.searchsorted(owner, owner, side="left")
        third = np.arange(len(owner)) - starts
        cut = self.split[owner]
        base, layer1, q = (
            _thirds(degree, net)
            for degree, net in ((1, self.base), (2, self.layer1[..., None]), (1, self.q[..., None]))
        )
        whole = (self.base, self.layer1, self.q)
        parts = (base, layer1[..., 0], q[..., 0])
        base, layer1, q = (
            np.where(cut.reshape(-1, *(1,) * (one.ndim - 1)), part[owner, third], one[owner])
            for one, part in zip(whole, parts, strict=True)
        )
        return FacePieces(
            owner, np.where(cut, third, -1), base, self.layer0[owner, third], self.rational[owner], layer1, q
        )


def _thirds(degree: int, net: Float) -> Float:
    """Nets (N, 3, n, dim) of degree 1 or 2 on the thirds of triangles, the centre in place of corner s."""
    result = np.repeat(net[:, None], 3, axis=1)
    if degree == 1:
        centre = net.mean(axis=1)
        for s in range(3):
            result[:, s, s] = centre
        return result
    # the polar form with the centre as one argument, by corner
    once = np.stack([sum_of(net, s) / 3.0 for s in range(3)], axis=1)
    twice = once.mean(axis=1)
    for s in range(3):
        i, j = int(J[s]), int(K[s])
        result[:, s, _place(i, s)], result[:, s, _place(j, s)] = once[:, i], once[:, j]
        result[:, s, _place(s, s)] = twice
    return result


def sum_of(net: Float, corner: int) -> Float:
    """Sum of the ordinates of quadratic nets (N, 6, dim) at a corner and towards the two others."""
    return (
        net[:, _place(corner, corner)] + net[:, _place(corner, int(J[corner]))] + net[:, _place(corner, int(K[corner]))]
    )


def foot_weight(x: Float, p: Float, q: Float) -> Float:
    """alpha(x, p, q) of (3.1): 3 beta - 1, with beta the weight of p in the foot of x on the line through p and q."""
    along = p - q
    weight: Float = dot(2.0 * (x - q) + (x - p), along) / dot(along, along)
    return weight


def middle_coefficient(
    x: Float, ends: tuple[Float, Float], vectors: tuple[Float, Float], turn: Float | None = None
) -> Float:
    """F(i, j, x), the coefficient of the triangle p_i p_j x, from the data of its edge: (4.10) and step 4.

    Half-way along the edge, the derivative perpendicular to the edge is that of (n_i + n_j) / 2. Affine in x, whatever
    tetrahedra hold the edge: hence F is C1 along it.

    Parameters
    ----------
    x
        (..., 3) third point.
    ends, vectors
        p_i, p_j and n_i, n_j, (..., 3) each.
    turn
        (..., 3) vectors perpendicular to the edge, added to (n_i + n_j) / 2; None for zero.
    """
    (p, q), (n_p, n_q) = ends, vectors
    alpha = foot_weight(x, p, q)
    towards_q, towards_p = dot(q - p, n_p) / 3.0, dot(p - q, n_q) / 3.0
    value: Float = 0.5 * (dot(x - p, n_p) / 3.0 + dot(x - q, n_q) / 3.0 + alpha * towards_q + (1.0 - alpha) * towards_p)
    return value if turn is None else value + dot(x - p, turn) / 3.0


def face_nets(
    faces: Int, base: Float, vectors: Float, apex: Float, split: Bool, turns: Float | None = None
) -> FaceNets:
    """Return F over the tetrahedra of faces, steps 1 to 5 and the default of step 8.

    Parameters
    ----------
    faces
        (N,) mesh faces.
    base, vectors
        (N, 3, 3) corners p_0 p_1 p_2 and the gradients of F there; a face's orientation does not matter.
    apex
        (N, 3).
    split
        (N,) true where F is to be three cubics.
    turns
        (N, 3, 3) by edge s, see :func:`middle_coefficient`.
    """
    ends, at_ends = (base[:, J], base[:, K]), (vectors[:, J], vectors[:, K])
    centre = base.mean(axis=1)
    legs = dot(base[:, None] - base[:, :, None], vectors[:, :, None]) / 3.0  # [a, b]: at p_a towards p_b
    rise = dot(apex[:, None] - base, vectors) / 3.0
    number2 = middle_coefficient(base, ends, at_ends, turns)
    number3 = middle_coefficient(np.broadcast_to(apex[:, None], base.shape), ends, at_ends, turns)
    mean2 = number2.mean(axis=1)
    rational = np.where(split[:, None], 0.0, number2 - mean2[:, None])

    layer0 = np.zeros((len(base), 10))
    layer1 = np.empty((len(base), 6))
    for s in range(3):
        i, j = int(J[s]), int(K[s])
        layer0[:, _place(s, s, i)], layer0[:, _place(s, s, j)] = legs[:, s, i], legs[:, s, j]
        layer1[:, _place(s, s)], layer1[:, _place(i, j)] = rise[:, s], number3[:, s]
    layer0[:, _place(0, 1, 2)] = mean2
    thirds = np.where(split[:, None, None], clough_tocher(base, vectors, legs, centre, turns), layer0[:, None])
    default = 0.5 * layer1.sum(axis=1) - 0.2 * layer0.sum(axis=1)
    return FaceNets(
        faces, base, vectors, apex, split, thirds, rational, layer1, quadratic_layer(layer0, layer1), default
    )


def clough_tocher(base: Float, vectors: Float, legs: Float, centre: Float, turns: Float | None) -> Float:
    """Layer 0 of split faces, (N, 3, 10): three cubics with the centre in place of corner s, C1 inside."""
    ends, at_ends = (base[:, J], base[:, K]), (vectors[:, J], vectors[:, K])
    middles = middle_coefficient(np.broadcast_to(centre[:, None], base.shape), ends, at_ends, turns)
    spokes = dot(centre[:, None] - base, vectors) / 3.0
    second = (spokes + middles[:, J] + middles[:, K]) / 3.0
    net = np.zeros((len(base), 3, 10))
    for s in range(3):
        i, j = int(J[s]), int(K[s])
        for a, b in ((i, j), (j, i)):
            net[:, s, _place(a, a, b)] = legs[:, a, b]
            net[:, s, _place(a, a, s)] = spokes[:, a]
            net[:, s, _place(a, s, s)] = second[:, a]
        net[:, s, _place(i, j, s)] = middles[:, s]
    net[:, [0, 1, 2], [_place(s, s, s) for s in range(3)]] = second.mean(axis=1)[:, None]
    return net


def quadratic_layer(layer0: Float, layer1: Float) -> Float:
    """Return q1001, q0101, q0011, (N, 3), of the quadratic nearest to layers 0 and 1: the least squares of (4.13).

    In closed form; the sixteen equations have weight one each.
    """

    def at(*corners: int) -> Float:
        return layer0[:, _place(*corners)]

    def up(*corners: int) -> Float:
        return layer1[:, _place(*corners)]

    columns = []
    for s in range(3):
        i, j = int(J[s]), int(K[s])
        columns.append(
            21.0 * up(s, s)
            + 9.0 * (up(s, i) + up(s, j))
            - 3.0 * (up(i, i) + up(i, j) + up(j, j) + at(s, s, i) + at(s, s, j))
            - (at(i, i, s) + at(i, j, s) + at(j, j, s))
            + (at(i, i, j) + at(j, j, i))
        )
    return np.stack(columns, axis=-1) / 20.0
