"""Polynomials for exp, sin and cos that vectorise inside compiled loops.

`math.exp` and its kin keep a loop scalar. The coefficients are Chebyshev interpolants, computed at import.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel

Array = NDArray[np.float64]

#: exp(-z) is taken as exp(-LARGEST_EXPONENT) beyond it: 4e-18, below rounding beside 1.
LARGEST_EXPONENT = 40.0
SQUARINGS = 6
#: The rotation polynomials hold for |half angle| up to this. [rad]
LARGEST_HALF_ANGLE = 1.6


def monomials(function: Callable[[Array], Array], high: float, degree: int) -> tuple[float, ...]:
    """Coefficients, lowest first, of the Chebyshev interpolant of a function on [0, high]."""
    fit = Chebyshev.interpolate(function, degree, domain=[0.0, high])
    return tuple(fit.convert(kind=Polynomial, domain=[-1.0, 1.0], window=[-1.0, 1.0]).coef.tolist())


#: Of (1 - exp(-z))/z, (1 - sinc)/z and (1 - cos)/z, so that nothing is lost at 0.
DECAY = monomials(lambda z: -np.expm1(-z) / z, LARGEST_EXPONENT / 2**SQUARINGS, 9)
SINC = monomials(lambda z: (1.0 - np.sinc(np.sqrt(z) / np.pi)) / z, LARGEST_HALF_ANGLE**2, 6)
COS = monomials(lambda z: 2.0 * np.sin(0.5 * np.sqrt(z)) ** 2 / z, LARGEST_HALF_ANGLE**2, 7)


@kernel
def decay(exponent: float) -> float:
    """exp(-exponent) for a non-negative exponent, to 1e-14 relative to 1."""
    z = min(exponent * (1.0 / 2**SQUARINGS), LARGEST_EXPONENT / 2**SQUARINGS)
    # fmt: off
    e = 1.0 - z * (DECAY[0] + z * (DECAY[1] + z * (DECAY[2] + z * (DECAY[3] + z * (DECAY[4] + z * (
        DECAY[5] + z * (DECAY[6] + z * (DECAY[7] + z * (DECAY[8] + z * DECAY[9])))))))))
    # fmt: on
    e *= e
    e *= e
    e *= e
    e *= e
    e *= e
    return float(e * e)


@inlined
def sinc(z: float) -> float:
    """sin(a)/a of z = a^2, for |a| up to `LARGEST_HALF_ANGLE`."""
    # fmt: off
    return 1.0 - z * (SINC[0] + z * (SINC[1] + z * (SINC[2] + z * (SINC[3] + z * (
        SINC[4] + z * (SINC[5] + z * SINC[6]))))))
    # fmt: on


@inlined
def cosine(z: float) -> float:
    """cos(a) of z = a^2, for |a| up to `LARGEST_HALF_ANGLE`."""
    # fmt: off
    return 1.0 - z * (COS[0] + z * (COS[1] + z * (COS[2] + z * (COS[3] + z * (
        COS[4] + z * (COS[5] + z * (COS[6] + z * COS[7])))))))
    # fmt: on
