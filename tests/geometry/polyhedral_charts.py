"""Charts for tests: the unit sphere over the faces of polyhedra, a torus in tiles and flat polygons."""

from dataclasses import dataclass
from itertools import permutations, product
from typing import Any

import numpy as np

from testbed.geometry.charted import Charts
from testbed.geometry.jets import Jet
from testbed.geometry.taylor import Taylor
from testbed.geometry.vectors import Float, Int, cross, unit

GOLDEN = 0.5 * (1.0 + 5.0**0.5)
AXES: list[tuple[float, ...]] = [
    tuple(float(sign * (axis == k)) for k in range(3)) for axis in range(3) for sign in (1, -1)
]
DIAGONALS: list[tuple[float, ...]] = list(product((1.0, -1.0), repeat=3))


def signed_permutations(*numbers: float) -> list[tuple[float, ...]]:
    """All orders and signs of three numbers."""
    signed = {
        tuple(sign * x for sign, x in zip(signs, order, strict=True))
        for order in permutations(numbers)
        for signs in product((1, -1), repeat=3)
    }
    return sorted(signed)


def icosahedral(a: float, b: float) -> list[tuple[float, ...]]:
    """(0, a, b) with all signs, turned."""
    turned = [(0.0, s * a, t * b) for s, t in product((1, -1), repeat=2)]
    return [tuple(np.roll(one, shift)) for one in turned for shift in range(3)]


#: Vertices, and outward vectors through the middles of the faces.
POLYHEDRA: dict[str, tuple[list[tuple[float, ...]], list[tuple[float, ...]]]] = {
    "cuboctahedron (3 and 4 sides)": (signed_permutations(0, 1, 1), AXES + DIAGONALS),
    "dodecahedron (5 sides)": (DIAGONALS + icosahedral(1 / GOLDEN, GOLDEN), icosahedral(GOLDEN, 1)),
    "truncated octahedron (4 and 6 sides)": (signed_permutations(0, 1, 2), AXES + DIAGONALS),
}


@dataclass(frozen=True)
class SphereOverPolyhedron(Charts):
    """The unit sphere projected from its centre onto the planes of a polyhedron's faces."""

    polyhedron: str

    def frame(self, chart: Int) -> tuple[Float, Float, Float]:
        """Middles of faces and two orthonormal vectors in their planes, (N, 3) each."""
        vertices, middles = (np.array(values, dtype=np.float64) for values in POLYHEDRA[self.polyhedron])
        normal = unit(middles)[chart]
        height = (normal @ vertices.T).max(axis=1)
        # not along any face's normal
        first = unit(cross(normal, np.array([0.3, 0.5, 0.81])))
        return normal * height[:, None], first, cross(normal, first)

    def __len__(self) -> int:
        return len(POLYHEDRA[self.polyhedron][1])

    def polygon(self, chart: int) -> Float:
        middle, first, second = (vectors[0] for vectors in self.frame(np.array([chart])))
        vertices = np.array(POLYHEDRA[self.polyhedron][0], dtype=np.float64)
        heights = vertices @ unit(middle)
        corners = vertices[heights > heights.max() - 1e-9]
        at = np.stack([corners @ first, corners @ second], axis=-1)
        return at[np.argsort(np.arctan2(at[:, 1], at[:, 0]))]

    def jets(self, chart: Int, at: Float, order: int = 2) -> Jet:
        u, v = Taylor.variables(at, order)
        middle, first, second = self.frame(chart)
        x: Any = middle + u[:, None] * first + v[:, None] * second
        return Jet((x / np.linalg.norm(x, axis=-1)[:, None]).coefficients)


@dataclass(frozen=True)
class TiledTorus(Charts):
    """The torus about the z axis in 4 x 3 rectangles of its angles, each scaled by its own factors."""

    major: float = 1.0
    minor: float = 0.4

    def __len__(self) -> int:
        return 12

    def polygon(self, chart: int) -> Float:
        corners = np.array([[0.0, 0.0], [0.5 * np.pi, 0.0], [0.5 * np.pi, 2.0 * np.pi / 3.0], [0.0, 2.0 * np.pi / 3.0]])
        return corners * (1.0 + chart)

    def jets(self, chart: Int, at: Float, order: int = 2) -> Jet:
        u, v = Taylor.variables(at / (1.0 + chart)[:, None], order)
        u, v = u + 0.5 * np.pi * (chart // 3), v + 2.0 * np.pi / 3.0 * (chart % 3)
        rho = self.major + self.minor * np.cos(v)
        torus: Any = np.stack([rho * np.cos(u), rho * np.sin(u), self.minor * np.sin(v)], axis=-1)
        coefficients = torus.coefficients.copy()
        scale = 1.0 / (1.0 + chart)[:, None]
        coefficients[1:3] *= scale
        coefficients[3:] *= scale**2
        return Jet(coefficients)


@dataclass(frozen=True)
class FlatPolygon(Charts):
    """A regular polygon in the plane z = 0, parametrised askew."""

    sides: int

    def __len__(self) -> int:
        return 1

    def polygon(self, chart: int) -> Float:
        angle = 2.0 * np.pi * np.arange(self.sides) / self.sides + chart
        return np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    def jets(self, chart: Int, at: Float, order: int = 2) -> Jet:
        u, v = Taylor.variables(at, order)
        askew: Any = np.stack([10.0 * u + 3.0 * v, 0.5 * v, 0.0 * u + 0.0 * chart], axis=-1)
        return Jet(askew.coefficients)
