"""Data on one side of a plane: heights over it, what quartics may reach below it, and normals that leave room there.

A vertex of height A whose faces allow ordinates down to -r (:mod:`testbed_schemes.mathematics.quartic_lower_bound`) has
room for tangents that fall by A + r. Tangents that fall farther are shortened (Si 2015, section 5.2.2), down to nothing
on the plane itself, where only its own normal is possible. Normals that are estimates anyway are turned towards the
plane's where less than a part :data:`LEAST` of a tangent would be left.

Fill: turned normals are not in the source.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Bool, Float, cross, dot, norm, tangential, unit
from testbed_schemes.mathematics.quartic_lower_bound import lower_ordinate

#: A vertex lies on the plane if its height is this small against its coordinates: rounding.
ON_PLANE = 64 * float(np.finfo(np.float64).eps)
#: Sine of the angle with the plane's normal up to which a normal there is taken for it.
PARALLEL = 1e-10
#: The least part of a tangent that shortening is to leave; for the rest, normals are turned.
LEAST = 0.1


@dataclass(frozen=True, eq=False)
class PlaneSide:
    """Vertices as they lie to one side of a plane.

    Parameters
    ----------
    direction
        (3,) unit normal of the plane, towards the side.
    heights
        (V,) distances of the vertices from the plane, negative on the other side; zero for those that rounding alone
        keeps off it.
    """

    direction: Float
    heights: Float

    @classmethod
    def of_plane(cls, plane: tuple[float, float, float, float], points: Float) -> "PlaneSide":
        """Return the upper side of a x + b y + c z + d = 0, where that is positive, for points (V, 3)."""
        length = norm(np.array(plane[:3]))
        normal, offset = np.array(plane[:3]) / length, plane[3] / length
        heights = dot(points, normal) + offset
        heights[np.abs(heights) <= ON_PLANE * (np.abs(points * normal).sum(axis=1) + np.abs(offset))] = 0.0
        return cls(normal, heights)

    def other(self) -> "PlaneSide":
        """Return the other side."""
        return PlaneSide(-self.direction, 0.0 - self.heights)

    def bounds(self, mesh: HermiteMesh) -> Float:
        """(F,) how far below the plane control points of quartics may lie, all heights being at least zero."""
        return lower_ordinate(*self.heights[mesh.faces].T)

    def foreign(self, normals: Float) -> Bool:
        """(V,) true for vertices on the plane whose normal is not the plane's: no surface stays on its side there."""
        return np.asarray((self.heights == 0.0) & ~(norm(cross(normals, self.direction)) <= PARALLEL))

    def settled(self, normals: Float) -> Float:
        """Return the normals with those of vertices on the plane made the plane's, on the side they point to."""
        upright = np.where(dot(normals, self.direction)[:, None] < 0.0, -self.direction, self.direction)
        return np.where((self.heights == 0.0)[:, None], upright, normals)

    def turned(self, normals: Float, mesh: HermiteMesh) -> tuple[Float, Bool]:
        """Return the normals, turned towards the plane's where tangents would be shortened too much, and where (V,).

        Tangents along the chords' shadows on the plane then are left as long as :data:`LEAST`; that is what the turn is
        found from, whatever they are made of.
        """
        bounds = np.append(self.bounds(mesh), np.inf)[mesh.edge_faces].min(axis=1)
        ends = mesh.edges
        chord = tangential(mesh.points[ends[:, ::-1]] - mesh.points[ends], self.direction) / 4.0
        upright = dot(normals, self.direction)
        with np.errstate(divide="ignore", invalid="ignore"):  # upright tangent planes: they fall without end
            fall = dot(chord, normals[ends]) / upright[ends]
            factor = (self.heights[ends] + bounds[:, None]) / (LEAST * fall)
        slopes = np.ones(len(normals))
        np.minimum.at(slopes, ends, np.where(fall > 0.0, factor, 1.0))
        # the part along the plane is what slopes are proportional to
        steep = slopes < 1.0
        flat = tangential(normals, self.direction)
        turned = unit(upright[:, None] * self.direction + slopes[:, None] * flat)
        return self.settled(np.where(steep[:, None], turned, normals)), steep
