"""The meshes on which schemes are checked: small, closed and open, friendly and not, with exact data where possible."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import polynomial

from testbed.geometry.face_data import Centres, FaceData
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, Int, as_float, norm, unit
from testbed.plugins.scheme import Shape

#: Coefficients c[i, j] of x^i y^j of a polynomial of degree six without symmetry, with slopes below one on [-1, 1]^2.
GENERIC = np.array(
    [
        [0.00, 0.05, -0.12, 0.031, 0.012, -0.007, 0.003],
        [-0.08, 0.11, 0.043, -0.023, 0.009, 0.004, 0.0],
        [0.17, -0.037, 0.019, 0.011, -0.006, 0.0, 0.0],
        [0.041, 0.027, -0.013, 0.005, 0.0, 0.0, 0.0],
        [-0.022, 0.008, 0.007, 0.0, 0.0, 0.0, 0.0],
        [0.009, -0.005, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.004, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    ]
)


#: Semi-axes of the ellipsoid.
AXES = np.array([1.0, 1.4, 2.0])


@dataclass(frozen=True)
class Case:
    """A mesh to check schemes on.

    Parameters
    ----------
    name
        What a witness calls it.
    mesh
        The data.
    shapes
        The shapes it was sampled from exactly, of those that a scheme may claim to reproduce.
    implicit
        A function (..., 3) to (...) that vanishes on that shape and has a gradient of length near one there, or None.
    """

    name: str
    mesh: HermiteMesh
    shapes: tuple[Shape, ...] = ()
    implicit: Callable[[Float], Float] | None = None


def graph(x: Float, y: Float, faces: Int, coefficients: Float = GENERIC) -> HermiteMesh:
    """Sample the graph z = p(x, y) at (V,) abscissae, with upward normals and exact second fundamental forms.

    Quadrilaterals have samples at their centres, too.
    """
    centres = None
    if faces.shape[1] == 4:
        middle = [coordinates[faces].mean(axis=1) for coordinates in (x, y)]
        centres = Centres(*_on_graph(middle[0], middle[1], coefficients))
    points, normals, forms = _on_graph(x, y, coefficients)
    return HermiteMesh(points, faces, normals, forms, face_data=FaceData(centres))


def _on_graph(x: Float, y: Float, coefficients: Float) -> tuple[Float, Float, Float]:
    """Points, normals and second fundamental forms of the graph at (N,) abscissae."""

    def derivative(i: int, j: int) -> Float:
        c = polynomial.polyder(polynomial.polyder(coefficients, i, axis=0), j, axis=1)
        return np.asarray(polynomial.polyval2d(x, y, c), dtype=np.float64)

    normals = unit(np.stack([-derivative(1, 0), -derivative(0, 1), np.ones_like(x)], axis=-1))
    hessian = np.zeros((len(x), 3, 3))
    hessian[:, 0, 0], hessian[:, 1, 1] = derivative(2, 0), derivative(0, 2)
    hessian[:, 0, 1] = hessian[:, 1, 0] = derivative(1, 1)
    tangent = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    # II = -<D^2 S, n>, and <D^2 S, n> is the Hessian of p over the slope factor, which is n_z
    forms = -tangent @ hessian @ tangent * normals[:, 2, None, None]
    return np.stack([x, y, derivative(0, 0)], axis=-1), normals, symmetric(forms)


def symmetric(forms: Float) -> Float:
    """Return the symmetric parts of (V, 3, 3) matrices."""
    half: Float = 0.5 * (forms + forms.swapaxes(-1, -2))
    return half


def sphere(points: Float, faces: Int) -> HermiteMesh:
    """Return the mesh with its vertices, normals and second forms on the unit sphere."""
    points = unit(points)
    return HermiteMesh(points, faces, points, np.eye(3) - points[:, :, None] * points[:, None, :])


def octahedron() -> HermiteMesh:
    """Eight faces, valence 4."""
    points = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float64)
    faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    return sphere(points, np.array(faces))


def tetrahedron() -> HermiteMesh:
    """Four faces, valence 3, arcs of 109 degrees."""
    points = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=np.float64)
    return sphere(points, np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))


def icosahedron() -> HermiteMesh:
    """Twenty faces, valence 5."""
    g = 0.5 * (1.0 + np.sqrt(5.0))
    points = [[0, s, t * g] for s in (1, -1) for t in (1, -1)]
    points = (
        points + [[s, t * g, 0] for s in (1, -1) for t in (1, -1)] + [[t * g, 0, s] for s in (1, -1) for t in (1, -1)]
    )
    vertices = np.array(points, dtype=np.float64)
    near = np.abs(((vertices[:, None] - vertices[None]) ** 2).sum(axis=-1) - 4.0) < 1e-9
    i, j, k = (axis.ravel() for axis in np.indices((12, 12, 12)))
    triangle = (i < j) & (i < k) & near[i, j] & near[j, k] & near[i, k]
    faces = np.stack([i, j, k], axis=-1)[triangle]
    outward = np.einsum("fi,fi->f", np.cross(vertices[faces[:, 1]], vertices[faces[:, 2]]), vertices[faces[:, 0]]) > 0
    return sphere(vertices, faces[outward])


def perturbed_icosahedron() -> HermiteMesh:
    """Turn the icosahedron's normals by some ten degrees and give it generic second forms (seed 7)."""
    mesh, random = icosahedron(), np.random.default_rng(7)
    normals = unit(mesh.points + 0.2 * random.uniform(-1.0, 1.0, mesh.points.shape))
    tangent = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    noise = random.uniform(-1.0, 1.0, (12, 3, 3))
    forms = tangent @ (np.eye(3) + 0.2 * symmetric(noise)) @ tangent
    return HermiteMesh(mesh.points, mesh.faces, normals, symmetric(forms))


def torus(around: int, across: int, sides: int, twist: float = 0.0) -> HermiteMesh:
    """Sample a torus of radii 1 and 0.4 on a grid with no row on its top circle; quadrilaterals or triangles.

    Quadrilaterals have samples at their centres, too; a twist by whole steps around the axis, on the way around the
    tube, leaves them no symmetry.
    """
    i, j = (axis.ravel() for axis in np.meshgrid(np.arange(around), np.arange(across), indexing="ij"))
    i1, j1 = i + 1, (j + 1) % across
    # the last row meets the first one, so many steps on
    k, k1 = (i + round(twist) * (j1 == 0)) % around, (i1 + round(twist) * (j1 == 0)) % around
    quads = np.stack([i * across + j, i1 % around * across + j, k1 * across + j1, k * across + j1], axis=-1)
    points, normals, forms = _on_torus(as_float(i + twist * j / across), as_float(j), around, across)
    if sides == 3:
        return HermiteMesh(points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]), normals, forms)
    middle = _on_torus(as_float(i + twist * (j + 0.5) / across + 0.5), as_float(j + 0.5), around, across)
    return HermiteMesh(points, quads, normals, forms, face_data=FaceData(Centres(*middle)))


def _on_torus(i: Float, j: Float, around: int, across: int) -> tuple[Float, Float, Float]:
    """Points, normals and second fundamental forms at (N,) steps around the axis and around the tube."""
    u, v = 2.0 * np.pi * (i + 0.21) / around, 2.0 * np.pi * (j + 0.13) / across
    out = np.stack([np.cos(u), np.sin(u), np.zeros_like(u)], axis=-1)
    normals = np.cos(v)[:, None] * out + np.stack([0 * v, 0 * v, np.sin(v)], axis=-1)
    along = np.stack([-np.sin(u), np.cos(u), np.zeros_like(u)], axis=-1)
    across_tube = np.cross(normals, along)
    forms = (np.cos(v) / (1.0 + 0.4 * np.cos(v)))[:, None, None] * along[:, :, None] * along[:, None, :]
    forms += across_tube[:, :, None] * across_tube[:, None, :] / 0.4
    return out + 0.4 * normals, normals, symmetric(forms)


def fan() -> tuple[Float, Float, Int]:
    """Plane triangulation with a vertex of valence 12, twelve of valence 5 and a boundary; no symmetry (seed 3)."""
    turn = 2.0 * np.pi * np.arange(12) / 12
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    outer = np.stack([np.cos(turn + np.pi / 12), np.sin(turn + np.pi / 12)], axis=-1)
    points = np.concatenate([[[0.0, 0.0]], 0.45 * ring, 0.95 * outer])
    points = points + np.random.default_rng(3).uniform(-0.03, 0.03, points.shape)
    k, after = np.arange(12), (np.arange(12) + 1) % 12
    faces = np.concatenate(
        [
            np.stack([np.zeros(12, dtype=np.int64), 1 + k, 1 + after], axis=-1),
            np.stack([1 + k, 13 + k, 1 + after], axis=-1),
            np.stack([1 + after, 13 + k, 13 + after], axis=-1),
        ]
    )
    return points[:, 0], points[:, 1], faces


def needles() -> HermiteMesh:
    """Return a strip of triangles a hundred times longer than wide, on the generic graph."""
    i, j = (axis.ravel() for axis in np.meshgrid(np.arange(5), np.arange(3), indexing="ij"))
    x, y = as_float(-0.9 + 0.45 * i + 0.01 * j), as_float(0.1 + 0.0045 * j)
    quads = np.array([[3 * a + b, 3 * a + b + 3, 3 * a + b + 4, 3 * a + b + 1] for a in range(4) for b in range(2)])
    return graph(x, y, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def grid(sides: int, steps: int, coefficients: Float = GENERIC) -> HermiteMesh:
    """Sample a graph over a sheared, uneven grid of the square with ``steps`` cells a side."""
    s, t = (
        axis.ravel() for axis in np.meshgrid(np.linspace(0, 1, steps + 1), np.linspace(0, 1, steps + 1), indexing="ij")
    )
    x, y = -0.8 + 1.5 * s + 0.1 * t + 0.08 * s * t, -0.7 + 1.3 * t - 0.15 * s - 0.05 * s * t
    i, j = (axis.ravel() for axis in np.meshgrid(np.arange(steps), np.arange(steps), indexing="ij"))
    corner = i * (steps + 1) + j
    quads = np.stack([corner, corner + steps + 1, corner + steps + 2, corner + 1], axis=-1)
    faces = quads if sides == 4 else np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return graph(x, y, faces, coefficients)


def _tilted_plane() -> Float:
    coefficients = np.zeros((2, 2))
    coefficients[1, 0], coefficients[0, 1] = 0.3, -0.2
    return coefficients


def ellipsoid() -> HermiteMesh:
    """Map the icosahedron to the ellipsoid with semi-axes 1, 1.4 and 2, with gradients of its equation."""
    mesh = icosahedron()
    points = mesh.points * AXES
    gradient = points / AXES**2
    normals = unit(gradient)
    tangent = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    forms = tangent @ np.diag(1.0 / AXES**2) @ tangent / norm(gradient)[:, None, None]
    return HermiteMesh(points, mesh.faces, normals, symmetric(forms), gradients=gradient)


def _off_sphere(points: Float) -> Float:
    return norm(points) - 1.0


def _off_ellipsoid(points: Float) -> Float:
    return norm(points / AXES) - 1.0


def _off_plane(points: Float) -> Float:
    return points[..., 2] - 0.3 * points[..., 0] + 0.2 * points[..., 1]


def cases(sides: int) -> tuple[Case, ...]:
    """Return the meshes of triangles (3) or quadrilaterals (4), the simplest first."""
    round_shapes = (Shape.SPHERES, Shape.QUADRICS)
    if sides == 4:
        return (
            Case("coarse torus of quadrilaterals", torus(8, 5, 4)),
            Case("twisted torus of quadrilaterals", torus(8, 5, 4, twist=1)),
            Case("open mesh of quadrilaterals", grid(4, 3)),
            Case("flat mesh of quadrilaterals", grid(4, 2, _tilted_plane()), (Shape.PLANES,), _off_plane),
        )
    return (
        Case("octahedron", octahedron(), round_shapes, _off_sphere),
        Case("icosahedron with perturbed normals", perturbed_icosahedron()),
        Case("coarse torus", torus(8, 5, 3)),
        Case("tetrahedron", tetrahedron(), round_shapes, _off_sphere),
        Case("ellipsoid", ellipsoid(), (Shape.QUADRICS,), _off_ellipsoid),
        Case("open mesh with a vertex of valence 12", graph(*fan())),
        Case("flat mesh", graph(*fan(), _tilted_plane()), (Shape.PLANES,), _off_plane),
        Case("needle faces", needles()),
        Case("one face", graph(np.array([0.1, 0.8, 0.3]), np.array([-0.2, 0.1, 0.7]), np.array([[0, 1, 2]]))),
    )
