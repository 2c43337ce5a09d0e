"""Two test functions of sensitivity analysis on the unit cube."""

import numpy as np

G_COEFFICIENTS = np.array([0.0, 1.0, 4.5, 9.0, 99.0, 99.0, 99.0, 99.0])


def ishigami(unit_points):
    """Ishigami & Homma 1990, a = 7, b = 0.1; inputs uniform on (-pi, pi)."""
    x1, x2, x3 = np.pi * (2.0 * unit_points.T - 1.0)
    return np.sin(x1) + 7.0 * np.sin(x2) ** 2 + 0.1 * x3**4 * np.sin(x1)


def sobol_g(unit_points):
    """Sobol' G: the first inputs matter, those of coefficient 99 do not."""
    return np.prod((np.abs(4.0 * unit_points - 2.0) + G_COEFFICIENTS) / (1.0 + G_COEFFICIENTS), axis=1)
