"""All solutions of two crossed parabolas are found, against the eigenvalues of a companion matrix."""

import numpy as np

from testbed_schemes.mathematics.crossed_parabolas import positive_solutions


def test_all_positive_solutions_of_two_crossed_parabolas_are_found() -> None:
    rng = np.random.default_rng(4)
    count = 3000
    a = np.repeat(rng.normal(size=(1, count)), 2, axis=0)
    b, e = rng.normal(size=(2, count)), rng.normal(size=(2, count))
    solutions = positive_solutions(a, b, e, 1e-4, 1e4)
    companion = np.zeros((count, 4, 4))
    companion[:, 1, 0] = companion[:, 2, 1] = companion[:, 3, 2] = 1.0
    lead = b[0] * b[1] ** 2
    companion[:, 0, 3] = -(b[0] * e[1] ** 2 - e[0] * a[1] ** 2) / lead
    companion[:, 1, 3] = -a[0] * a[1] ** 2 / lead
    companion[:, 2, 3] = 2.0 * b[0] * b[1] * e[1] / lead
    roots = np.linalg.eigvals(companion)
    x = roots.real
    y = (e[1, :, None] - b[1, :, None] * x**2) / a[1, :, None]
    real = (np.abs(roots.imag) < 1e-9 * np.abs(roots)) & (x > 2e-4) & (y > 2e-4) & (x < 1e3) & (y < 1e3)
    nearest = np.abs(solutions[0].T[:, None, :] - x[..., None])
    nearest = np.where(np.isnan(nearest), np.inf, nearest).min(axis=-1)
    assert real.sum() > 500
    assert (nearest[real] < 1e-6 * x[real]).all()
