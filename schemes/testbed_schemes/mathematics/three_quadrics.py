"""All real roots of three quadrics in three unknowns, for many systems at once.

In homogeneous coordinates (1, x, y, z) the multiples of the three quadrics by the ten monomials of degree 2 are 30 rows
over the 35 monomials of degree 4, of rank 27 (Macaulay 1902). The null space is spanned, for eight simple roots, by the
monomials of degree 4 evaluated at the roots. On it, multiplication by a linear form is an 8 x 8 matrix whose
eigenvectors hold the coordinates of the roots, complex ones and those at infinity included. Roots of multiplicity m
have a part 1/m of the digits. So every eigenvector, complex ones too, is only a start of a damped Newton method on the
real quadrics, and what ends at a zero to rounding is a root: real double roots that rounding has made complex are
found, and nothing else is taken for one.

Where the quadrics meet in a curve or a surface some of its points are found, from the origin and a place beside it too.
"""

from itertools import combinations_with_replacement

import numpy as np

from testbed.geometry.vectors import Bool, Float, Int, cross, dot

#: Common zeros of three quadrics in space, complex ones and those at infinity included.
ROOTS = 8
#: A value below this against the sum of its terms' sizes is zero.
RESIDUAL = 1e-12
#: Two roots nearer than this, relative to the larger of one and their size, are one.
SAME = 1e-5
#: Roots farther away than this are at infinity.
FARTHEST = 1e8
#: Newton steps at most: towards a double root each halves the distance, towards others of multiplicity m it leaves a
#: part 1 - 1/m.
STEPS = 60
#: Damping against the squares of the Jacobian: it keeps steps short where the Jacobian is singular, or so nearly that
#: rounding decides on the step.
DAMPING = 1e-12
#: Diagonal elements below this against the largest are those of a singular triangular matrix.
SINGULAR = 1e-14
#: Two linear forms of the four coordinates, as good as any others on whose planes no root lies.
DIVISOR = np.array([0.6180339887, 0.3247179572, -0.2207440846, 0.1673039782])
FACTOR = np.array([-0.1419634902, 0.5698402910, 0.4142135624, -0.3819660113])
#: Starts of Newton's method besides the eigenvectors.
FURTHER = np.array([[0.0, 0.0, 0.0], [0.0618033989, 0.0324717957, -0.0220744085]])


def _monomials(degree: int) -> list[tuple[int, ...]]:
    """Return the monomials of a degree in four variables, as sorted indices of their factors."""
    return list(combinations_with_replacement(range(4), degree))


def _places(degree: int, times: int) -> Int:
    """Return where the products of the monomials of two degrees stand among those of their sum, (n, m)."""
    place = {monomial: k for k, monomial in enumerate(_monomials(degree + times))}
    products = [[place[tuple(sorted(one + other))] for other in _monomials(times)] for one in _monomials(degree)]
    return np.array(products, dtype=np.int64)


#: Columns of a quadric's multiple by a monomial of degree 2, (10, 10), and of a monomial of degree 3 times a
#: coordinate, (20, 4).
_MULTIPLES, _SHIFTS = _places(2, 2), _places(3, 1)
#: The two factors of each of the ten monomials of degree 2.
_FIRST, _SECOND = np.array(_monomials(2), dtype=np.int64).T
#: 27 mixtures of the 30 rows, generic, so that no row that the others do not replace is left out.
_MIXTURE = np.random.default_rng(1902).normal(size=(30, 27))


def values(quadrics: Float, at: Float) -> tuple[Float, Float]:
    """Values of quadrics (..., 3, 4, 4) at points (..., 3), and the sums of the sizes of their terms, (..., 3) each."""
    X = np.concatenate([np.ones((*at.shape[:-1], 1)), at], axis=-1)
    value = np.einsum("...qij,...i,...j->...q", quadrics, X, X)
    return value, np.einsum("...qij,...i,...j->...q", np.abs(quadrics), np.abs(X), np.abs(X))


def real_roots(quadrics: Float) -> Float:
    """Return all real roots of systems of three quadrics.

    Parameters
    ----------
    quadrics
        (N, 3, 4, 4) symmetric matrices A; q(x) = X . A X with X = (1, x, y, z). A quadric that is zero everywhere is no
        condition; a system with infinite coefficients has no roots.

    Returns
    -------
    Float
        (N, 10, 3) roots, the nearest to the origin first, each once, NaN after the last: at most eight, or up to ten
        points of a curve or surface of roots. The roots of a system do not depend on which others there are.
    """
    size = np.abs(quadrics).max(axis=(2, 3), keepdims=True)
    finite = np.isfinite(size).all(axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):  # infinite ones, which are left out
        scaled = np.where(finite, quadrics / np.where(size > 0.0, size, 1.0), 0.0)
    further = np.broadcast_to(FURTHER, (len(scaled), *FURTHER.shape))
    points, root = _polished(scaled, np.concatenate([_starts(scaled), further], axis=1))
    return _distinct(points, root & finite[:, :, 0, 0])


def _starts(quadrics: Float) -> Float:
    """Real parts (N, 8, 3) of all roots, complex ones too, with the digits that their multiplicities leave."""
    count = len(quadrics)
    coefficients = quadrics[..., _FIRST, _SECOND] * np.where(_FIRST == _SECOND, 1.0, 2.0)
    rows = np.zeros((count, 3, 10, 35))
    for monomial in range(10):
        rows[:, :, monomial, _MULTIPLES[monomial]] = coefficients
    mixed = np.matmul(rows.reshape(count, 30, 35).swapaxes(1, 2), _MIXTURE)
    null = np.linalg.qr(mixed, mode="complete")[0][..., -ROOTS:]  # (N, 35, 8)
    shifted = np.moveaxis(null[:, _SHIFTS], 2, 0)  # (4, N, 20, 8): at the monomials of degree 3 times a coordinate
    q, r = np.linalg.qr(np.einsum("k,knmr->nmr", DIVISOR, shifted))
    by_coordinate = np.matmul(q.swapaxes(1, 2), shifted)  # (4, N, 8, 8)
    # where the null space is larger than it should be a start is as good as any other
    diagonal = np.einsum("nii->ni", r)
    least = SINGULAR * np.abs(diagonal).max(axis=1, keepdims=True)
    diagonal[...] = np.where(np.abs(diagonal) < least, least, diagonal)
    _, vectors = np.linalg.eig(np.linalg.solve(r, np.einsum("k,knij->nij", FACTOR, by_coordinate)))
    monomials = np.matmul(r, vectors)
    X = np.einsum("nis,knis->nsk", monomials.conj(), np.matmul(by_coordinate, vectors))
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):  # at infinity
        roots: Float = (X[..., 1:] / X[..., :1]).real
    return np.where((np.abs(roots) <= FARTHEST).all(axis=2, keepdims=True), roots, 0.0)


def _polished(quadrics: Float, starts: Float) -> tuple[Float, Bool]:
    """Newton's method from starts (N, S, 3), damped; where it ends, and whether that is a root, (N, S)."""
    shape = starts.shape
    system, x = np.repeat(np.arange(shape[0]), shape[1]), starts.reshape(-1, 3).copy()
    value, terms = values(quadrics[system], x)
    active = np.arange(len(x))
    for _ in range(STEPS):
        A = quadrics[system[active]]
        X = np.concatenate([np.ones((len(active), 1)), x[active]], axis=-1)
        jacobian = 2.0 * np.einsum("nqij,ni->nqj", A[..., 1:], X)
        error = (value[active] ** 2).sum(axis=1)
        waiting = np.arange(len(active))
        for stepping, part in ATTEMPTS:
            step = stepping(jacobian[waiting], value[active[waiting]])
            new = x[active[waiting]] + part * step
            new_value, new_terms = values(A[waiting], new)
            better = (new_value**2).sum(axis=1) < error[waiting]
            moved = active[waiting[better]]
            x[moved], value[moved], terms[moved] = new[better], new_value[better], new_terms[better]
            waiting = waiting[~better]
        active = np.delete(active, waiting)  # what does not descend has arrived
        if not len(active):
            break
    zero = np.abs(value) <= RESIDUAL * (terms + RESIDUAL)  # where all terms are zero at a root, too
    root: Bool = np.asarray(zero.all(axis=1) & (np.abs(x) <= FARTHEST).all(axis=1))
    return x.reshape(shape), root.reshape(shape[:2])


def _newton_step(jacobian: Float, value: Float) -> Float:
    """Newton steps (n, 3) for Jacobians (n, 3, 3); none where those are singular."""
    return _usable(np.einsum("nqi,nq->ni", _transposed_inverse(jacobian), value))


def _damped_step(jacobian: Float, value: Float) -> Float:
    """Damped least-squares steps (n, 3), nearly the shortest ones."""
    normal = np.einsum("nqi,nqj->nij", jacobian, jacobian)
    trace = np.einsum("nii->n", normal)
    np.einsum("nii->ni", normal)[...] += (DAMPING * trace)[:, None]
    gradient = np.einsum("nqi,nq->ni", jacobian, value)
    return _usable(np.einsum("nij,nj->ni", _transposed_inverse(normal), gradient))


def _transposed_inverse(matrix: Float) -> Float:
    """Transposed inverses (n, 3, 3) of matrices (n, 3, 3), by cofactors; not finite where there is none."""
    a, b, c = matrix[:, 0], matrix[:, 1], matrix[:, 2]
    cofactors = np.stack([cross(b, c), cross(c, a), cross(a, b)], axis=1)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        inverse: Float = cofactors / dot(a, cofactors[:, 0])[:, None, None]
    return inverse


def _usable(step: Float) -> Float:
    """Steps (n, 3) in the other direction; zero where they are not finite."""
    return np.where(np.isfinite(step).all(axis=1, keepdims=True), -step, 0.0)


#: Steps that are tried, and parts of them, until one descends.
ATTEMPTS = ((_newton_step, 1.0), (_damped_step, 1.0), (_newton_step, 0.5), (_newton_step, 0.125), (_damped_step, 0.1))


def _distinct(points: Float, root: Bool) -> Float:
    """Roots (N, S, 3) among points, the nearest to the origin first, each once; NaN in the other rows."""
    distance = np.where(root, np.einsum("nsi,nsi->ns", points, points), np.inf)
    order = np.argsort(distance, axis=1, kind="stable")
    points = np.take_along_axis(points, order[..., None], axis=1)
    kept = np.take_along_axis(root, order, axis=1)
    apart = np.abs(points[:, :, None] - points[:, None]).max(axis=3)
    same = apart <= SAME * np.maximum(1.0, np.abs(points).max(axis=2))[:, :, None]
    for later in range(1, points.shape[1]):
        kept[:, later] &= ~(same[:, later, :later] & kept[:, :later]).any(axis=1)
    front = np.argsort(~kept, axis=1, kind="stable")
    result: Float = np.take_along_axis(np.where(kept[..., None], points, np.nan), front[..., None], axis=1)
    return result
