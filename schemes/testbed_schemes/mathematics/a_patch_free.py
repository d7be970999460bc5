"""A choice of A-patches' free coefficients that keeps quadrics (to Xu, Huang and Bajaj 2001, step 8 of section 4.2).

Where the data are those of a quadric Q, with vectors that are its gradients, F is Q if and only if the free coefficient
f0003 of every face is Q(apex). The paper's default, which makes the cubic nearly linear, is not; **fill**: the data of
a face fix a quadratic up to a multiple of the square of alpha_4, the apex's barycentric coordinate, and that multiple
is fitted to the vertices opposite the face's edges and to the vectors there. It needs no Q, and finds it where there is
one.
"""

from functools import cache

import numpy as np

from testbed.geometry.bernstein import index_of, multi_indices
from testbed.geometry.simplex_bernstein import simplex_multi_indices, simplex_places
from testbed.geometry.vectors import Bool, Float, Int, cross, dot, norm
from testbed_schemes.mathematics.a_patch_coefficients import FaceNets
from testbed_schemes.mathematics.split_domain import J, K

# Opposite vertices that are all nearer to the face's plane than this part of the apex's height say nothing; those
# nearer than the second say something only if the quadric meets them exactly, for what is cubic in the data is divided
# by that part and would drown the rest.
_FLAT, _WEAK = 1e-9, 0.05
#: Misfit of vectors, relative, up to which data are those of a quadric.
_EXACT = 1e-9


def quadric_parameters(nets: FaceNets, opposite: Float, vectors: Float) -> Float:
    """Return free coefficients f0003 (N,) with which quadrics are kept, from the neighbouring vertices of faces.

    Parameters
    ----------
    nets
        F over the tetrahedra of N faces on one side.
    opposite
        (N, 3, 3) the vertex of the neighbouring face opposite edge s, NaN where there is none.
    vectors
        (N, 3, 3) the given vectors there, in the frame of the side.

    Returns
    -------
    Float
        (N,) the least squares of q(p_l) + f alpha_4(p_l)^2 = 0 and L (grad(q + f alpha_4^2)(p_l) - n_l) = 0 over the
        opposite vertices p_l, with q the quadratic of :func:`nearest_quadratic` and L the mean edge length. The paper's
        default where nothing determines f: no neighbours, or all of them in the face's plane, or nearly so while the
        data are not those of a quadric.
    """
    values, gradients, weight, slope = _at_opposite(nets, opposite)
    lengths = norm(nets.base[:, K] - nets.base[:, J])
    length = (lengths[:, 0] + lengths[:, 1] + lengths[:, 2])[:, None] / 3.0
    # f alpha^2 has the gradient 2 f alpha grad alpha
    along = 2.0 * weight[..., None] * slope[:, None]
    area = length * length
    numerator = values * weight * weight + area * dot(gradients - vectors, along)
    denominator = weight**4 + area * dot(along, along)
    there = np.isfinite(denominator)
    numerator, denominator = np.where(there, numerator, 0.0), np.where(there, denominator, 0.0)
    useful: Bool = np.asarray((np.where(there, np.abs(weight), 0.0) > _FLAT).any(axis=1))
    total = numerator[:, 0] + numerator[:, 1] + numerator[:, 2]
    base = denominator[:, 0] + denominator[:, 1] + denominator[:, 2]
    free = -total / np.where(useful, base, 1.0)
    misfit = norm(gradients + free[:, None, None] * along - vectors) / norm(vectors)
    strong: Bool = np.asarray((np.where(there, np.abs(weight), 0.0) > _WEAK).any(axis=1))
    exact: Bool = np.asarray((np.where(there, misfit, 0.0) < _EXACT).all(axis=1))
    return np.where(useful & (strong | exact), free, nets.default)


def opposite_vertices(faces: Int, edges: Int, face_edges: Int, edge_faces: Int) -> Int:
    """Return the vertex (F, 3) of the face beyond edge s, the one opposite corner s, of each face; -1 where none is.

    The arguments are those of a mesh of triangles.
    """
    across = np.roll(face_edges, -1, axis=1)  # side s + 1 is opposite corner s
    both = edge_faces[across]
    neighbour = both.sum(axis=2) - np.arange(len(faces))[:, None]
    found: Int = faces[neighbour].sum(axis=2) - edges[across].sum(axis=2)
    return np.where((both < 0).any(axis=2), -1, found)


def whole_layer0(nets: FaceNets) -> Float:
    """Return layer 0 (N, 10) of the whole faces' cubics, the rational term left out, also of split faces.

    The number 2 coefficients of a split face are affine in the third point: those of the whole face follow.
    """
    result = np.zeros((len(nets), 10))
    centre = np.zeros(len(nets))
    for s in range(3):
        i, j = int(J[s]), int(K[s])
        iij, ijj, ijs = (index_of((p.count(0), p.count(1), p.count(2))) for p in ((i, i, j), (i, j, j), (i, j, s)))
        net = nets.layer0[:, s]
        result[:, iij], result[:, ijj] = net[:, iij], net[:, ijj]
        centre += (3.0 * net[:, ijs] - (net[:, iij] + net[:, ijj])) / 3.0
    middle = index_of((1, 1, 1))
    result[:, middle] = np.where(nets.split, centre, nets.layer0[:, 0, middle])
    return result


def nearest_quadratic(layer0: Float, layer1: Float) -> Float:
    """Return the quadratic (N, 10) over [p_0 p_1 p_2 u] nearest to cubics' layers 0 and 1, with q0002 = 0.

    The least squares of all sixteen equations (4.13), of weight one. Its coefficients q1001, q0101 and q0011 are those
    of :func:`~testbed_schemes.mathematics.a_patch_coefficients.quadratic_layer`.

    Parameters
    ----------
    layer0, layer1
        (N, 10), (N, 6) ordinates of whole faces.

    Returns
    -------
    Float
        (N, 10) in the order of ``simplex_multi_indices(4, 2)``.
    """
    layers = np.concatenate([layer0, layer1], axis=1)
    result = np.zeros((len(layers), 10))
    # term after term: the same bits however many faces there are
    for ordinate, factors in zip(layers.T, _least_squares().T, strict=True):
        result[:, :9] += ordinate[:, None] * factors
    return result


def elevation_equations() -> Float:
    """Return the matrix (16, 9) of (4.13): layers 0 and 1 of a quadratic raised to degree 3, from all but q0002."""
    wanted = np.concatenate(
        [
            np.column_stack([multi_indices(3 - layer), np.full(len(multi_indices(3 - layer)), layer)])
            for layer in range(2)
        ]
    )
    matrix = np.zeros((16, 10))
    for row, exponents in enumerate(wanted):
        for i in np.flatnonzero(exponents):
            lower = exponents - np.eye(4, dtype=np.int64)[i]
            matrix[row, simplex_places(lower)] += exponents[i] / 3.0
    return matrix[:, :9]


@cache
def _least_squares() -> Float:
    """Pseudo-inverse (9, 16) of the elevation, read-only."""
    inverse: Float = np.linalg.pinv(elevation_equations()).astype(np.float64, copy=False)
    inverse.flags.writeable = False
    return inverse


def _at_opposite(nets: FaceNets, points: Float) -> tuple[Float, Float, Float, Float]:
    """Values (N, 3) and gradients (N, 3, 3) of the nearest quadratic at points, alpha_4 there, and grad alpha_4."""
    q = nearest_quadratic(whole_layer0(nets), nets.layer1)
    slopes = _barycentric_gradients(nets.base, nets.apex)
    # from p_0, where the weights are (1, 0, 0, 0)
    offset = points - nets.base[:, :1]
    weights = [dot(offset, slopes[:, None, i]) + (i == 0) for i in range(4)]
    values = np.zeros(points.shape[:2])
    gradients = np.zeros(points.shape)
    for place, exponents in enumerate(simplex_multi_indices(4, 2).tolist()):
        first, *rest = (i for i in range(4) for _ in range(exponents[i]))
        second = rest[0]
        # B = alpha_i^2 or 2 alpha_i alpha_j
        factor = q[:, place, None] * (1.0 if first == second else 2.0)
        values += factor * (weights[first] * weights[second])
        gradients += (factor * weights[first])[..., None] * slopes[:, None, second]
        gradients += (factor * weights[second])[..., None] * slopes[:, None, first]
    return values, gradients, weights[3], slopes[:, 3]


def _barycentric_gradients(base: Float, apex: Float) -> Float:
    """Gradients (N, 4, 3) of the barycentric coordinates over [p_0 p_1 p_2 u]."""
    a, b, c = base[:, 1] - base[:, 0], base[:, 2] - base[:, 0], apex - base[:, 0]
    volume = dot(a, cross(b, c))[:, None]
    one, two, three = cross(b, c) / volume, cross(c, a) / volume, cross(a, b) / volume
    return np.stack([-(one + two + three), one, two, three], axis=1)
