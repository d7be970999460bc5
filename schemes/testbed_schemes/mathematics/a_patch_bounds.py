"""Lower bounds of A-patches' free coefficients (Xu, Huang and Bajaj 2001, step 6 of section 4.2).

The free coefficient of a face is bounded from below by the thresholds of its shooting polynomials
(:mod:`testbed_schemes.mathematics.a_patch_shooting`): above them the surface is smooth and single sheeted.
The bound of a face is the supremum of the threshold over its points with b_0 < 0, the bound of an edge that over the
segments between the edge and the line that joins the two apexes. Both are found by search, see
:mod:`testbed_schemes.mathematics.a_patch_search`. The formula for the edge's coefficients is missing in the paper as
printed; here it follows from the layers of the tetrahedron.
"""

import numpy as np

from testbed.geometry.bernstein import multi_indices
from testbed.geometry.vectors import Bool, Float, Int
from testbed_schemes.mathematics.a_patch_edges import tetrahedron_place
from testbed_schemes.mathematics.a_patch_search import suprema
from testbed_schemes.mathematics.a_patch_shooting import shooting_bound

# A bound is exceeded by this part of the larger of itself and the default, lest roots become double.
MARGIN = 1e-3


def face_bounds(layer0: Float, rational: Float, layer1: Float, q: Float) -> Float:
    """Return the bound B_ijk of f0003 on each piece of the faces: above it all shooting polynomials are good.

    Parameters
    ----------
    layer0, rational, layer1, q
        (R, 10), (R, 3), (R, 6), (R, 3) of tetrahedra with one formula each, as in
        :class:`~testbed_schemes.mathematics.a_patch_coefficients.FacePieces`; the bound of a split face is the largest
        of its three pieces'.

    Returns
    -------
    Float
        (R,) suprema over the base triangle of the threshold with b0 < 0 the layer 0 with its rational term, b1 the
        layer 1, b2 = 2/3 (q0 alpha_1 + q1 alpha_2 + q2 alpha_3), b3 = 0 and beta = 1; -inf where b0 is nowhere
        negative, NaN where a coefficient is. Accurate to about 1e-10 of the coefficients.
    """

    def values(rows: Int, at: Float) -> Float:
        u, v = at[..., 0], at[..., 1]
        alpha = (1.0 - u - v, u, v)
        b0 = _triangle(layer0[rows], alpha) + _rational_term(rational[rows], alpha)
        b1 = _triangle(layer1[rows], alpha)
        b2 = 2.0 / 3.0 * _triangle(q[rows], alpha)
        return _negative_threshold(b0, b1, b2, np.zeros(()), noise[rows])

    scale = _largest(layer0, rational, layer1, q)
    # cubics along sides with b0 = 0 are not to be taken for negative ones by rounding
    noise = 1e-14 * _largest(layer0, rational)
    return suprema(values, scale, 3)


def edge_bounds(nets: Float, rational: Float, mu: Float, nu: Float) -> Float:
    """Return the bound B_ijkl of what has to be added to f0003 and f3000 of both faces of each edge.

    Parameters
    ----------
    nets, rational
        (N, 20), (N, 4) coefficients over [u_l p_i p_j u_k], as in
        :class:`~testbed_schemes.mathematics.a_patch_edges.EdgeNets`, with the free coefficients they are to be added
        to in them.
    mu, nu
        (N, 4) weights (4.15).

    Returns
    -------
    Float
        (N,) suprema over x, y in [0, 1] of the threshold for the segment from q = x p_i + (1 - x) p_j, b0(q) < 0, to
        u = y u_k + (1 - y) u_l, with the factor of :func:`edge_factor`; negative where the coefficients are above
        their bounds already, -inf where b0 is nowhere negative. NaN where the threshold is not negative and that factor
        not positive: raising the coefficients does not help, and the edge is to be refused or changed.
    """
    place = _edge_places()

    def values(rows: Int, at: Float) -> Float:
        x, y = at[..., 0], at[..., 1]
        net, term = nets[rows], rational[rows]
        x1, y1 = 1.0 - x, 1.0 - y
        powers, powers1 = ((np.ones(()), z, z * z, z * z * z) for z in (x, x1))

        def along(*names: str) -> Float:
            """Layer with the ends' exponents (n, 0) to (0, n), as a polynomial in x."""
            degree = len(names) - 1
            total = np.zeros(x.shape)
            for k, name in enumerate(names):
                factor = _BINOMIAL[degree][k] * net[:, place[name], None]
                total += factor * (powers[degree - k] * powers1[k])
            return total

        b0 = along("0300", "0210", "0120", "0030")
        b1 = y1 * along("1200", "1110", "1020") + y * along("0201", "0111", "0021")
        cross = 2.0 * y * y1
        b2 = y1 * y1 * along("2100", "2010") + cross * along("1101", "1011") + y * y * along("0102", "0012")
        a1101, b1101, a1011, b1011 = (term[:, k, None] for k in range(4))
        b2 += cross * (x * (a1101 * y1 + b1101 * y) + x1 * (a1011 * y1 + b1011 * y))
        b3 = y1 * y1 * y1 * along("3000") + 1.5 * cross * (y1 * along("2001") + y * along("1002"))
        b3 += y * y * y * along("0003")
        beta = edge_factor(y, mu[rows, 3, None], nu[rows, 0, None])
        threshold = _negative_threshold(b0, b1, b2, b3, noise[rows])
        helpless = np.where(threshold < 0.0, -np.inf, np.nan)
        return np.where(beta > 0.0, threshold / np.where(beta > 0.0, beta, 1.0), helpless)

    scale = _largest(nets, rational)
    noise = 1e-14 * np.abs(nets[:, [place["0210"], place["0120"]]]).max(axis=1, initial=0.0)
    return suprema(values, scale, 4)


def edge_factor(y: Float, mu4: Float, nu1: Float) -> Float:
    """Return beta(y): raising f0003 and f3000 by b adds beta(y) t^2 b to the edge's shooting polynomials.

    As printed, in a shorter form: (1 - y)^2 + y^2 + 2 y (1 - y) (nu1 (1 - y) + mu4 y). Raising the face at y = 1 alone
    adds y^2 (1 + 2 (1 - y) mu4), not negative for mu4 >= -1/2, and likewise for the other.
    """
    factor: Float = (1.0 - y) ** 2 + y**2 + 2.0 * y * (1.0 - y) * (nu1 * (1.0 - y) + mu4 * y)
    return factor


def raised_bounds(bounds: Float, of_edges: Float, rows: Int) -> Float:
    """Return the faces' bounds (N,) raised by the largest positive bound of their edges.

    The paper adds the bounds of a face's edges as they come; the largest is enough. **Fill**.

    Parameters
    ----------
    bounds
        (N,) of faces.
    of_edges
        (E,) of edges, found with the free coefficients at ``bounds``. NaN propagates to both faces.
    rows
        (E, 2) the two faces of each edge.
    """
    raise_by = np.zeros(len(bounds))
    with np.errstate(invalid="ignore"):  # NaN stays
        for side in range(2):
            np.maximum.at(raise_by, rows[:, side], of_edges)
    return bounds + raise_by


def above(chosen: Float, bounds: Float, margin: float = MARGIN, scale: Float | None = None) -> Float:
    """Return free coefficients (N,): those chosen, or a margin above their bounds where they are not that high.

    **Fill**: the paper takes max(chosen, bound), and at the bound a root is double. The margin is a part of the larger
    modulus of the two, or of the bound and a ``scale`` where the choice may be far off.
    """
    with np.errstate(invalid="ignore"):  # -inf + inf: no bound, chosen is taken
        lowest = bounds + margin * np.maximum(np.abs(chosen if scale is None else scale), np.abs(bounds))
    return np.where(bounds == -np.inf, chosen, np.maximum(chosen, lowest))


_BINOMIAL = ((1.0,), (1.0, 1.0), (1.0, 2.0, 1.0), (1.0, 3.0, 3.0, 1.0))


def _edge_places() -> dict[str, int]:
    """Places of the edge's coefficients by the exponents of u_l, p_i, p_j, u_k."""
    names = [f"{i}{j}{k}{3 - i - j - k}" for i in range(4) for j in range(4 - i) for k in range(4 - i - j)]
    return {name: tetrahedron_place(*(s for s in range(4) for _ in range(int(name[s])))) for name in names}


def _triangle(net: Float, alpha: tuple[Float, Float, Float]) -> Float:
    """Values (n, S) of nets (n, ordinates) at barycentric coordinates (n, S) each."""
    degree = {3: 1, 6: 2, 10: 3}[net.shape[1]]
    powers = [[np.ones(()), a, a * a, a * a * a] for a in alpha]
    total: Float = np.zeros(alpha[0].shape)
    for ordinate, (i, j, k) in zip(net.T, multi_indices(degree).tolist(), strict=True):
        factor = _BINOMIAL[degree][i] * _BINOMIAL[degree - i][j]
        total += (factor * ordinate)[:, None] * (powers[0][i] * powers[1][j] * powers[2][k])
    return total


def _rational_term(coefficients: Float, alpha: tuple[Float, Float, Float]) -> Float:
    """Rational term of (4.1), 0 where two barycentric coordinates vanish, as its limit is."""
    pairs = (alpha[1] * alpha[2], alpha[2] * alpha[0], alpha[0] * alpha[1])
    total = pairs[0] + pairs[1] + pairs[2]
    weighted = sum((coefficients[:, s, None] * pairs[s] for s in range(3)), np.zeros(total.shape))
    inside = total > 0.0
    term: Float = 6.0 * alpha[0] * pairs[0] * np.divide(weighted, total, out=np.zeros(total.shape), where=inside)
    return term


def _negative_threshold(b0: Float, b1: Float, b2: Float, b3: Float, noise: Float) -> Float:
    """Return the threshold for a factor of one where b0 < 0, -inf elsewhere; NaN stays."""
    asked: Bool = ~(b0 >= -noise[:, None])
    result = np.full(b0.shape, -np.inf)
    result[asked] = shooting_bound(*(np.broadcast_to(b, b0.shape)[asked] for b in (b0, b1, b2, b3)))
    return result


def _largest(*arrays: Float) -> Float:
    """Return the largest modulus (N,) among the rows of several arrays."""
    largest: Float = np.stack([np.abs(array).max(axis=1) for array in arrays]).max(axis=0)
    return largest
