"""Orthotropy of a sheet in its plane, such as short fibres give it, as it is declared."""

from dataclasses import dataclass
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from analysis.declared import Declared

MOST_CONTRAST = 0.8
"""Largest |delta_e|: Ey is then nine times Ex."""
MOST_SHEAR = 3.0
Modulus = Annotated[float, Field(ge=1e6, le=1e12, description="Pa")]


@dataclass(frozen=True)
class Orthotropy:
    """Departure of a sheet from isotropy, referred to its own axes.

    E_x = E(1 - delta_e), E_y = E(1 + delta_e), nu_xy nu_yx = nu**2, in-plane shear modulus
    (1 + delta_g) E / 2(1 + nu); the transverse shear modulus stays E / 2(1 + nu).

    Attributes
    ----------
    delta_e, delta_g : float
    angle : float
        Of the sheet's x axis against the plate's, rad, towards y.
    """

    delta_e: float
    delta_g: float
    angle: float = 0.0


class DeclaredOrthotropy(Declared):
    """``[plate.material.orthotropy]``: delta_e and delta_g, or the moduli Ex, Ey and G12 themselves."""

    delta_e: Annotated[float | None, Field(ge=-MOST_CONTRAST, le=MOST_CONTRAST)] = None
    delta_g: Annotated[float | None, Field(ge=-0.9, le=MOST_SHEAR)] = None
    youngs_modulus_x: Annotated[float | None, Field(ge=1e6, le=1e12, description="Pa")] = None
    youngs_modulus_y: Annotated[float | None, Field(ge=1e6, le=1e12, description="Pa")] = None
    shear_modulus: Annotated[float | None, Field(ge=1e5, le=1e12, description="Pa, in the plane")] = None
    angle: Annotated[float, Field(ge=-180.0, le=180.0, description="degrees, of the sheet's x axis")] = 0.0

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        shares = (self.delta_e, self.delta_g)
        moduli = (self.youngs_modulus_x, self.youngs_modulus_y, self.shear_modulus)
        given = [all(v is not None for v in group) for group in (shares, moduli)]
        absent = [all(v is None for v in group) for group in (shares, moduli)]
        if (given[0] and absent[1]) == (given[1] and absent[0]):
            raise ValueError(
                "give either delta_e and delta_g, or youngs_modulus_x, youngs_modulus_y and shear_modulus; "
                "all of one group and none of the other"
            )
        return self

    @property
    def mean_modulus(self) -> float | None:
        """Mean of both moduli, Pa; None where shares are declared."""
        if self.youngs_modulus_x is None or self.youngs_modulus_y is None:
            return None
        return 0.5 * (self.youngs_modulus_x + self.youngs_modulus_y)

    def at(self, poisson_ratio: float) -> Orthotropy:
        """Return the value object; moduli are turned into shares with nu = sqrt(nu_xy nu_yx).

        ValueError for moduli whose shares leave the allowed range.
        """
        angle = float(np.deg2rad(self.angle))
        if self.delta_e is not None and self.delta_g is not None:
            return Orthotropy(self.delta_e, self.delta_g, angle)
        if self.youngs_modulus_x is None or self.youngs_modulus_y is None or self.shear_modulus is None:
            raise AssertionError("either group is complete")
        total = self.youngs_modulus_x + self.youngs_modulus_y
        delta_e = (self.youngs_modulus_y - self.youngs_modulus_x) / total
        delta_g = self.shear_modulus * 4.0 * (1.0 + poisson_ratio) / total - 1.0
        if not abs(delta_e) <= MOST_CONTRAST:
            raise ValueError(
                f"youngs_modulus_x {self.youngs_modulus_x:g} Pa, youngs_modulus_y {self.youngs_modulus_y:g} Pa: "
                f"(Ey - Ex)/(Ey + Ex) is {delta_e:.3g}; allowed -{MOST_CONTRAST} to {MOST_CONTRAST}"
            )
        if not -0.9 <= delta_g <= MOST_SHEAR:
            raise ValueError(
                f"shear_modulus {self.shear_modulus:g} Pa is {1.0 + delta_g:.3g} times an isotropic sheet's; "
                f"allowed 0.1 to {1.0 + MOST_SHEAR:g} times"
            )
        return Orthotropy(delta_e, delta_g, angle)
