"""One cubic in place of three on nonconvex faces of A-patches (Xu, Huang and Bajaj 2001, the note of section 4.2).

Along an edge p_i p_j all tetrahedra share the affine function x -> F(i, j, x). The three cubics take it from the data
alone. A single cubic has one number 2 coefficient for its three edges, F(0, 1, 2), which is free; it prescribes the
affine function at the corner opposite each edge, and the number 3 coefficients follow, the C1 conditions (2.3). So the
gradient at the middle of the edge is (n_i + n_j) / 2 plus a *turn* perpendicular to the edge, and what the data say
there is given up.

Formulas: the note's conditions as printed. **Fill**: with one single cubic at an edge, the least turn; next to a flat
face the turn is perpendicular to it. Free coefficients start at the mean of (4.10) to (4.12) and are moved by
projections until no number 3 coefficient is negative. Where that cannot be had, the paper would go on, but rays from
points with F = 0 then may start on the wrong side of the surface, which tears at the pinches of edges: such faces keep
three cubics.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.vectors import Bool, Float, Int, cross, dot, norm
from testbed_schemes.mathematics.a_patch_classes import Convexity
from testbed_schemes.mathematics.a_patch_coefficients import middle_coefficient
from testbed_schemes.mathematics.a_patch_sides import SIDES, Hull, face_normals
from testbed_schemes.mathematics.split_domain import J, K

#: Least sine of the angle of two faces that count as not coplanar: the turns are that much larger than their causes.
COPLANAR = 1e-3
#: Steps of the projections.
STEPS = 100
#: How far above zero they aim, as part of the number 1 coefficients at the ends of the edge.
AIM = 1e-3


@dataclass(frozen=True, slots=True)
class SingleCubics:
    """Nonconvex faces that are one cubic, and the turns at their edges.

    Attributes
    ----------
    single
        (F,) those faces.
    turns
        (F, 3, 3) turns by edge opposite corner s.
    given_up
        Faces that keep three cubics as some number 3 coefficient would be negative.
    """

    single: Bool
    turns: Float
    given_up: int


def may_be_single(found: Hull) -> Bool:
    """Return the nonconvex faces (F,) for which the note's conditions hold.

    None of the neighbours is coplanar with the face, and the products of its normal with theirs have one sign.
    """
    mesh = found.mesh
    normals = face_normals(mesh.corner_points())
    pairs = mesh.edge_faces[mesh.face_edges]
    neighbour = np.where(pairs[..., 0] == np.arange(len(pairs))[:, None], pairs[..., 1], pairs[..., 0])
    there = neighbour >= 0
    sine = norm(cross(normals[:, None], normals[neighbour]))
    product = dot(normals[:, None], normals[neighbour])
    apart = ((sine > COPLANAR) | ~there).all(axis=1)
    agree = ((product > 0.0) | ~there).all(axis=1) | ((product < 0.0) | ~there).all(axis=1)
    result: Bool = (found.faces == Convexity.NONCONVEX) & apart & agree
    return result


def single_cubics(found: Hull) -> SingleCubics:
    """Return single cubics wherever :func:`may_be_single` and no number 3 coefficient needs to be negative."""
    single = may_be_single(found)
    eligible = int(single.sum())
    corners, vectors = found.mesh.corner_points(), found.vectors[found.mesh.faces]
    free = middle_coefficient(corners, (corners[:, J], corners[:, K]), (vectors[:, J], vectors[:, K])).mean(axis=1)
    while True:
        edges = _Edges.of(found, single)
        free, spoilt = edges.lifted(free)
        if not spoilt.any():
            break
        single &= ~spoilt
    # edge s of a face, opposite corner s, is its side s + 1
    return SingleCubics(single, edges.turns(free)[found.mesh.face_edges[:, J]], eligible - int(single.sum()))


@dataclass(frozen=True, slots=True)
class _Edges:
    """Edges of a mesh and what turns there depend on; two faces an edge, in the order of ``mesh.edge_faces``.

    Attributes
    ----------
    faces
        (E, 2), -1 for none.
    single
        (E, 2) true for a face that is a single cubic.
    plain
        (E, 2) coefficients F(i, j, x) without a turn, at the corners opposite.
    response
        (E, 2, 3): what a unit deviation from those coefficients adds to the turn.
    ends, end_vectors
        p_i, p_j and vectors there.
    apexes
        (E, 2, 2, 3) apexes of the faces by side, NaN where there are none.
    """

    faces: Int
    single: Bool
    plain: Float
    response: Float
    ends: tuple[Float, Float]
    end_vectors: tuple[Float, Float]
    apexes: Float

    @classmethod
    def of(cls, found: Hull, single: Bool) -> "_Edges":
        mesh, vectors = found.mesh, found.vectors
        faces = mesh.edge_faces
        there = faces >= 0
        start, end = mesh.edges.T
        side = np.argmax(mesh.face_edges[faces] == np.arange(len(faces))[:, None, None], axis=2)
        far = mesh.points[np.take_along_axis(mesh.faces[faces], ((side + 2) % 3)[..., None], axis=2)[..., 0]]
        p, q = mesh.points[start], mesh.points[end]
        along = q - p
        offset = far - p[:, None]
        across = offset - (dot(offset, along[:, None]) / dot(along, along)[:, None])[..., None] * along[:, None]
        # beside single cubics flat faces hold the affine function, too: at zero
        alone = there & single[faces]
        holds = alone | (alone[:, ::-1] & there & (found.faces[faces] == Convexity.ZERO))
        apexes = np.where(there[..., None, None], np.moveaxis(found.apexes[:, faces], 0, 2), np.nan)
        plain = middle_coefficient(far, (p[:, None], q[:, None]), (vectors[start][:, None], vectors[end][:, None]))
        return cls(
            faces,
            alone,
            plain,
            _least_turns(across, holds),
            (p, q),
            (vectors[start], vectors[end]),
            apexes,
        )

    def turns(self, free: Float) -> Float:
        """Return the turns (E, 3) for number 2 coefficients ``free`` (F,) of the single cubics."""
        deviation = np.where(self.single, free[self.faces] - self.plain, 0.0)
        return deviation[:, :1] * self.response[:, 0] + deviation[:, 1:] * self.response[:, 1]

    def lifted(self, free: Float) -> tuple[Float, Bool]:
        """Move coefficients (F,) until number 3 coefficients are positive, if possible.

        Projections onto all half-spaces at once, each face taking the mean of what its conditions ask for. Also returns
        the faces (F,) to give up where one stays negative: of two at an edge the one that lacks more.
        """
        (p, q), (n_p, n_q) = ((one[:, None, None] for one in pair) for pair in (self.ends, self.end_vectors))
        sign = np.array(SIDES)
        plain3 = sign * middle_coefficient(self.apexes, (p, q), (n_p, n_q))
        aim = AIM * sign * (dot(self.apexes - p, n_p) + dot(self.apexes - q, n_q)) / 6.0
        reach = dot((self.apexes - p)[:, :, :, None], self.response[:, None, None]) / 3.0
        slope = np.where(self.single[:, None, None], sign[:, None] * reach, 0.0)  # edge, face, side, face that turns
        edge, face, side = np.nonzero(np.isfinite(plain3) & (slope != 0.0).any(axis=3))
        plain3, slope, aim = plain3[edge, face, side], slope[edge, face, side], aim[edge, face, side]
        owner, plain2 = np.where(self.single, self.faces, 0)[edge], self.plain[edge]
        square = slope[:, 0] * slope[:, 0] + slope[:, 1] * slope[:, 1]
        turning = slope != 0.0
        counts = np.maximum(np.bincount(owner[turning], minlength=len(free)), 1)

        def values() -> Float:
            deviation = free[owner] - plain2
            value: Float = plain3 + (slope[:, 0] * deviation[:, 0] + slope[:, 1] * deviation[:, 1])
            return value

        for _ in range(STEPS):
            lack = np.maximum(aim - values(), 0.0) / square
            if not lack.any():
                break
            free = free + np.bincount(owner.ravel(), (lack[:, None] * slope).ravel(), len(free)) / counts
        missing = np.maximum(-values(), 0.0) / np.sqrt(square)
        lacks = np.where(
            turning, np.bincount(owner[turning], np.repeat(missing, 2).reshape(-1, 2)[turning], len(free))[owner], 0.0
        )
        spoilt = np.zeros(len(free), dtype=np.bool_)
        bad = (missing > 0.0)[:, None] & turning & (lacks == lacks.max(axis=1, keepdims=True))
        spoilt[owner[bad]] = True
        return free, spoilt


def _least_turns(across: Float, holds: Bool) -> Float:
    """Return what unit deviations add to turns, (E, 2, 3).

    Parameters
    ----------
    across
        (E, 2, 3) from the edge to the corners opposite, perpendicular to the edge.
    holds
        (E, 2) where the affine function is prescribed at the corner.
    """
    square = np.asarray(dot(across, across))
    one, two = across[:, 0], across[:, 1]
    product = np.asarray(dot(one, two))[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):  # one face at the edge, or two in one plane: not taken
        determinant = (square[:, 0] * square[:, 1])[:, None] - product * product
        both = np.stack(
            [(square[:, 1:] * one - product * two) / determinant, (square[:, :1] * two - product * one) / determinant],
            axis=1,
        )
        alone = across / square[..., None]
    pairs = (holds[:, 0] & holds[:, 1])[:, None, None]
    taken = np.where(pairs, both, np.where(holds[..., None], alone, 0.0))
    result: Float = 3.0 * taken
    return result
