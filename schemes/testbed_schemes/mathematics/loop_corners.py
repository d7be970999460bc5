"""Loop's limit surface over faces with one irregular corner, exact everywhere (after Stam 1998).

The corner cut off at half of a face again and again leaves three regular pieces each time, quartics of the control
vertices A^(n-1) C after n steps, where C are those of the face and A is the subdivision matrix of its neighbourhood. A
place in the face lies in one of them. With l the left eigenvector of the eigenvalue 1, so that the corner's limit is
l C, and the subdominant eigenvalue lambda, A^n = 1 l + lambda^n ((A - 1 l) / lambda)^n, and these powers are bounded:
derivatives, which grow as 2^n and 4^n, keep their digits at every depth.

At the corner itself derivatives along the sides vanish or grow without bound, as lambda is below or above 1/2, but the
tangent plane has a limit: first derivatives given there are of some fixed length and span it, second ones are NaN.

The matrices are read off the rules: a neighbourhood whose points are unit vectors is subdivided as any mesh is.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar, Self

import numpy as np

from testbed.geometry.bernstein import triangle_tables
from testbed.geometry.evaluation import apply_table
from testbed.geometry.jets import ROWS, Jet
from testbed.geometry.loop_subdivision import limit_weights, subdivided
from testbed.geometry.patches import PatchBatch
from testbed.geometry.triangulation import Triangulation, following, preceding
from testbed.geometry.vectors import Bool, Float, Int, as_float
from testbed_schemes.mathematics.box_spline import bezier_nets, patch_vertices, reflected

#: Halvings of the face; nearer to the corner, rounding of 1 - u - v cannot tell places from it.
DEEPEST = 53
#: Places evaluated together where every patch has its own.
RUN = 1024


@dataclass(frozen=True)
class CornerKind:
    """What the neighbourhood of an irregular corner is like.

    Parameters
    ----------
    faces
        Number of faces at the corner.
    place
        Which of them the patch is, counted from the boundary edge that leaves the corner; -1 for a corner inside.
    """

    faces: int
    place: int = -1

    @property
    def inside(self) -> bool:
        """Whether the corner is not on the boundary."""
        return self.place < 0

    @property
    def ring(self) -> int:
        """Neighbours of the corner."""
        return self.faces if self.inside else self.faces + 1

    @property
    def sides(self) -> tuple[int, int]:
        """Places in the ring of the other two corners of the patch."""
        return (0, 1) if self.inside else (self.place, self.place + 1)

    def vertices(self, faces: Triangulation, half_edge: Int) -> Int:
        """Control vertices (N, m) of patches given by the half edges (N,) that leave their irregular corners.

        The corner; its ring, inside from the end of the half edge on; further neighbours of that end and of the third
        corner, counterclockwise. Only the corner is irregular.
        """
        corner, end, apex = faces.start[half_edge], faces.end[half_edge], faces.apex[half_edge]
        from_corner = half_edge if self.inside else faces.onward[corner]
        on_boundary = not self.inside and self.place == 0, not self.inside and self.place == self.faces - 1
        at_end = (
            faces.ring(faces.onward[end], 4)[:, :2] if on_boundary[0] else faces.ring(following(half_edge), 6)[:, 3:]
        )
        at_apex = faces.ring(faces.onward[apex], 4) if on_boundary[1] else faces.ring(preceding(half_edge), 5)
        return np.concatenate([corner[:, None], faces.ring(from_corner, self.ring), at_end, at_apex[:, 3:]], axis=1)

    def neighbourhood(self) -> tuple[Triangulation, int]:
        """Return the faces next to the patch, vertices in the order of :meth:`vertices`, and the patch among them."""
        spokes = [1 + j for j in range(self.ring)]
        after = spokes[1:] + spokes[:1] if self.inside else spokes[1:]
        faces = [[0, a, b] for a, b in zip(spokes, after, strict=False)]
        end, apex = (spokes[j] for j in self.sides)
        last = 1 + self.ring
        if not self.inside and self.place == 0:
            opposite = last + 1
            faces += [[end, last, opposite]]
        else:
            opposite = last + 2
            beside = spokes[self.sides[0] - 1]
            faces += [[end, beside, last], [end, last, last + 1], [end, last + 1, opposite]]
        faces += [[end, opposite, apex], [apex, opposite, opposite + 1]]
        count = opposite + 2
        if self.inside or self.place < self.faces - 1:
            beyond = spokes[(self.sides[1] + 1) % self.ring]
            faces += [[apex, opposite + 1, opposite + 2], [apex, opposite + 2, beyond]]
            count += 1
        return Triangulation(np.array(faces), count), max(self.place, 0)

    @property
    def eigenvalue(self) -> float:
        """The subdominant eigenvalue lambda; on the boundary the larger of two, 1/2 along it and one across."""
        if self.inside:
            return float(0.375 + 0.25 * np.cos(2.0 * np.pi / self.faces))
        return max(0.5, self.across)

    @property
    def across(self) -> float:
        """On the boundary the eigenvalue whose eigenvector points inwards."""
        return float(0.375 + 0.25 * np.cos(np.pi / self.faces))

    def limit(self, count: int) -> Float:
        """Left eigenvector l (count,) of the eigenvalue 1."""
        result = np.zeros(count)
        if self.inside:
            chi = float(limit_weights(np.array(self.faces)))
            result[: 1 + self.ring] = chi
            result[0] = 1.0 - self.faces * chi
        else:
            result[[0, 1, self.ring]] = 2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0
        return result

    def tangents(self, count: int) -> Float:
        """Left eigenvectors (2, count) of lambda for the directions of the two sides of the patch."""
        result = np.zeros((2, count))
        side = np.array(self.sides)
        if self.inside:
            turn = 2.0 * np.pi / self.faces
            result[:, 1 : 1 + self.ring] = np.cos(turn * (np.arange(self.ring) - side[:, None])) * 2.0 / self.faces
            return result
        along, inward = np.zeros((2, count))
        along[[1, self.ring]] = 0.5, -0.5
        # inwards sin(i theta) at the inner neighbours, and what makes it an eigenvector at the corner and the ends
        angle = np.pi / self.faces * np.arange(self.ring)
        inward[1 : 1 + self.ring] = np.sin(angle)
        system = np.array([[0.75 - self.across, 1.0], [0.125, 0.5 - self.across]])
        inward[0], end = np.linalg.solve(system, [-0.375 * np.sin(angle).sum(), -0.125 * np.sin(angle[1])])
        inward[[1, self.ring]] = end
        # right eigenvectors: x_(i+1) = x_i - x_(i-1) along, from 1 to -1, and sin(i theta) inwards
        around = np.sin(np.pi / 3.0 * (np.arange(self.ring) - 0.5 * self.faces))
        x, y = around / around[0], np.sin(angle) * 2.0 / self.faces
        rows: Float = x[side, None] * along + y[side, None] * inward
        return rows


@dataclass(frozen=True, eq=False)
class LoopCorners(PatchBatch):
    """Patches of Loop's limit surface whose corner 0 is irregular, all of one kind.

    Parameters
    ----------
    corner
        Their kind.
    control_points
        (P, m, 3), in the order of :meth:`CornerKind.vertices`.
    """

    corner: CornerKind
    control_points: Float
    sides: ClassVar[int] = 3
    kind: ClassVar[str] = "irregular patch of Loop's limit surface"
    #: Curvature may be unbounded at the corner, or have no limit there.
    corner_margin: float = 1e-3

    def __post_init__(self) -> None:
        points = as_float(self.control_points).view()
        points.flags.writeable = False
        object.__setattr__(self, "control_points", points)

    def __len__(self) -> int:
        return len(self.control_points)

    @property
    def work(self) -> float:
        """Control points of a patch over those of a cubic triangle."""
        return float(self.control_points.shape[1] / 10)

    def jets(self, at: Float, order: int = 2) -> Jet:
        """Jets at (S, 2) or (P, S, 2); see :meth:`PatchBatch.jets` and, for the corner, the module."""
        if at.ndim == 2:
            return Jet(apply_table(functions(self.corner, at, order), self.control_points))
        result = np.zeros((ROWS[order], *at.shape[:2], 3))
        run = max(1, RUN // max(at.shape[1], 1))
        with np.errstate(invalid="ignore", over="ignore"):  # a patch that is not finite stays so
            for start in range(0, len(self), run):
                patches = slice(start, start + run)
                places = at[patches]
                table = functions(self.corner, places.reshape(-1, 2), order).reshape(ROWS[order], *places.shape[:2], -1)
                for row, points in zip(
                    np.moveaxis(table, -1, 0), np.moveaxis(self.control_points[patches], 1, 0), strict=True
                ):
                    result[:, patches] += row[..., None] * points[:, None]
        return Jet(result)

    def take(self, patches: Int | slice) -> Self:
        """Return the chosen patches."""
        return type(self)(self.corner, self.control_points[patches])

    @property
    def finite(self) -> Bool:
        """(P,) true where every coordinate is finite."""
        return np.asarray(np.isfinite(self.control_points).all(axis=(1, 2)))


def functions(corner: CornerKind, at: Float, order: int) -> Float:
    """Jets (1 | 3 | 6, S, m) at places (S, 2) of the functions that the control vertices are weighted with."""
    nets = piece_nets(corner)
    count = nets.shape[-1]
    limit = corner.limit(count)
    total = at[:, 0] + at[:, 1]
    at_corner = ~(total > 2.0**-DEEPEST)
    # 2^-n <= u + v < 2^(1 - n), but for the side opposite the corner, which belongs to n = 1
    halvings = np.clip(1 - np.frexp(np.where(at_corner, 1.0, total))[1], 1, DEEPEST)
    scale = np.ldexp(1.0, halvings)
    u, v = scale * np.where(at_corner[:, None], 0.5, at).T
    piece = np.where(u >= 1.0, 0, np.where(v >= 1.0, 1, 2))
    local = np.stack(
        [np.choose(piece, [u - 1.0, u, 1.0 - u]), np.choose(piece, [v, v - 1.0, 1.0 - v])],
        axis=-1,
    )
    bernstein = triangle_tables(4, local, order)
    net = nets[halvings - 1, piece]
    rows = np.zeros((ROWS[order], len(at), count))
    for index in range(net.shape[1]):
        rows += bernstein[..., index, None] * net[:, index]
    shrinking = corner.eigenvalue ** (halvings - 1.0)
    turned = np.where(piece == 2, -scale, scale)
    rows[0] = limit + shrinking[:, None] * rows[0]
    if order > 0:
        rows[1:3] *= (shrinking * turned)[:, None]
        rows[1:3, at_corner] = corner.tangents(count)[:, None]
    if order > 1:
        rows[3:] *= (shrinking * scale * scale)[:, None]
        rows[3:, at_corner] = np.nan
    rows[0, at_corner] = limit
    return rows


@lru_cache(maxsize=64)
def piece_nets(corner: CornerKind) -> Float:
    """Nets (n, 3, 15, m) of the regular pieces after n = 1, 2, ... halvings, less the limit, over lambda^(n - 1).

    Piece 0 is at corner 1 of the patch, piece 1 at corner 2, piece 2 between them, its corner i opposite corner i of
    the whole.
    """
    faces, patch = corner.neighbourhood()
    points = subdivided(faces, np.eye(faces.vertices))
    finer = faces.refined()
    matrix = points[corner.vertices(finer, np.array([12 * patch]))[0]]
    whole, extended = reflected(finer, points)
    pieces = extended[patch_vertices(whole, 3 * (4 * patch + np.array([1, 2, 3])))]
    nets = bezier_nets(pieces)
    limit = corner.limit(faces.vertices)
    decaying = np.eye(faces.vertices) - limit
    step = (matrix - limit) / corner.eigenvalue
    result = np.empty((DEEPEST, *nets.shape))
    for halvings in range(DEEPEST):
        result[halvings] = nets @ decaying
        decaying = decaying @ step
    result.flags.writeable = False
    return result
