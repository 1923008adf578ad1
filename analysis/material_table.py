"""Material laws through tabulated values: what a simulated plate is made of."""

import numpy as np
from numpy.typing import NDArray

from analysis.material import Material, MaterialLaws


def laws_through(temperature: NDArray[np.float64], material: Material) -> MaterialLaws:
    """Return laws that pass through values at `temperature` exactly, and claim no uncertainty.

    Cubic splines of log E, nu and log eta without a knot at the second and the last but one value.

    Parameters
    ----------
    temperature : (T,) ndarray
        Ascending, degrees Celsius; at least 4.
    material : Material
        (T,) arrays.

    Raises
    ------
    ValueError
        For fewer than four temperatures, or such as do not ascend.
    """
    from scipy.interpolate import make_interp_spline

    if temperature.size < 4 or not (np.diff(temperature) > 0.0).all():
        raise ValueError(f"{temperature.size} temperatures, which must ascend; at least 4 make a law")
    curves = (np.log(material.youngs_modulus), material.poisson_ratio, np.log(material.loss_factor))
    splines = [make_interp_spline(temperature, curve, k=3) for curve in curves]
    coefficients = np.array([spline.c for spline in splines], dtype=np.float64)
    return MaterialLaws(
        knots=np.asarray(splines[0].t, dtype=np.float64),
        coefficients=coefficients,
        covariance=np.zeros((3, coefficients.shape[1], coefficients.shape[1])),
        temperature_range=(float(temperature[0]), float(temperature[-1])),
    )
