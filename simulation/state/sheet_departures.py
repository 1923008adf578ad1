"""Departures of an orthotropic sheet's moduli and loss factors from their declaration, by logarithms of ratios.

The laws give E = (E_x + E_y)/2 and eta, the root of eta_x eta_y, at every temperature. All else is constant over
temperature: r = log of E_y/E_x over the declared ratio, s = log of the shear modulus in the plane over the
declared share of E/2(1 + nu), p = log(eta_y/eta_x), q = log of the loss factor of shear over eta. With R = E_y/E_x

    E_x = 2 E/(1 + R),   E_y = 2 E R/(1 + R),   eta_x = eta exp(-p/2),   eta_y = eta exp(p/2).
"""

from typing import Any

import numpy as np

from analysis.declaration.plate_material import Orthotropy

FARTHEST_MODULI, FARTHEST_SHEAR, FARTHEST_LOSS = 0.9, 3.5, 2.3
"""Largest logarithms: of the ratios of moduli, of transverse shear moduli and of loss factors. The vectors of a
reduced plate follow its moduli so far, see `SHEETS`."""
Sheet = tuple[float, float, float, float]
"""Logarithms r, s and those of the transverse shear moduli of the planes xz and yz."""
SHEETS: tuple[Sheet, ...] = (
    (0.8, 0.0, 0.0, 0.0),
    (-0.8, -0.8, -1.5, -1.5),
    (0.0, 0.8, 1.5, 1.5),
    (0.0, 0.0, -3.0, -3.0),
)
"""States for which vectors are added about the declared moduli: good for a start anywhere in the range."""
ABOUT: tuple[Sheet, ...] = (
    (0.0, 0.0, 0.0, 0.0),
    (0.1, 0.0, -0.3, -0.3),
    (-0.1, 0.0, 0.3, 0.3),
    (0.0, 0.1, 0.0, 0.0),
    (0.0, -0.1, 0.0, 0.0),
)
"""The same about moduli that are known from such a start."""
CERTIFIED: Sheet = (0.35, -0.35, -0.5, -0.5)
CERTIFIED_NEAR: Sheet = (0.05, -0.05, -0.1, -0.1)
"""States in which the error is measured, about the declared and about known moduli."""


def departed_moduli(sheet: Orthotropy, ratio: Any, shear: Any) -> dict[str, Any]:
    """Return factors on the declared moduli, by their names in `Departures`; shear in all planes.

    Parameters
    ----------
    ratio, shear : float
        The logarithms r and s; complex for a complex step.

    Returns
    -------
    dict
        The transverse moduli follow the one in the plane unless they were declared.
    """
    apart = sheet.ratio * np.exp(ratio)
    found = {
        "modulus_x": 2.0 / (1.0 + apart) / (1.0 - sheet.delta_e),
        "modulus_y": 2.0 * apart / (1.0 + apart) / (1.0 + sheet.delta_e),
        "in_plane_shear": np.exp(shear),
    }
    across = 1.0 if sheet.declared_transverse else found["in_plane_shear"]
    return {**found, "shear_x": across, "shear_y": across}


def departed_transverse(xz: Any, yz: Any) -> dict[str, Any]:
    """Return factors on the transverse shear moduli of the planes xz and yz from their logarithms."""
    return {"shear_x": np.exp(xz), "shear_y": np.exp(yz)}


def departed_loss(ratio: Any, shear: Any) -> dict[str, Any]:
    """Return factors on the laws' loss factor from the logarithms p and q."""
    return {"loss_x": np.exp(-0.5 * ratio), "loss_y": np.exp(0.5 * ratio), "loss_shear": np.exp(shear)}
