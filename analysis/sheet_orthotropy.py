"""Orthotropy of a sheet in its plane, such as fibres and grain give it, as it is declared."""

from dataclasses import dataclass
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from analysis.declared import Declared

MOST_RATIO = 25.0
"""Largest ratio of both moduli, either way: unidirectional laminates have 10 to 20, spruce 7 to 15."""
MOST_CONTRAST = (MOST_RATIO - 1.0) / (MOST_RATIO + 1.0)
"""The same as |delta_e|."""
MOST_SHEAR = 3.0
"""Largest relative departure of a shear modulus from its isotropic value: four times it."""
Modulus = Annotated[float, Field(ge=1e5, le=1e12, description="Pa")]
Share = Annotated[float, Field(ge=-0.99, le=MOST_SHEAR)]


@dataclass(frozen=True)
class Orthotropy:
    """Departure of a sheet from isotropy, referred to its own axes.

    E = (E_x + E_y) / 2, E_x = E(1 - delta_e), E_y = E(1 + delta_e), nu_xy nu_yx = nu**2, in-plane shear modulus
    (1 + delta_g) E / 2(1 + nu), transverse shear moduli E / 2(1 + nu) times `transverse`.

    Attributes
    ----------
    delta_e, delta_g : float
    angle : float
        Of the sheet's x axis against the plate's, rad, towards y.
    transverse : (float, float)
        Of the planes xz and yz.
    declared_transverse : bool
        Whether these were declared; else they are those of the shear in the plane.
    """

    delta_e: float
    delta_g: float
    angle: float = 0.0
    transverse: tuple[float, float] = (1.0, 1.0)
    declared_transverse: bool = False

    def __post_init__(self) -> None:
        if not (abs(self.delta_e) < 1.0 and self.delta_g > -1.0 and min(self.transverse) > 0.0):
            raise ValueError(
                f"orthotropy: delta_e {self.delta_e:g}, delta_g {self.delta_g:g}, transverse {self.transverse}: "
                "|delta_e| must be below 1, delta_g above -1 and the transverse shear above 0"
            )

    @property
    def ratio(self) -> float:
        """E_y / E_x."""
        return (1.0 + self.delta_e) / (1.0 - self.delta_e)


class DeclaredOrthotropy(Declared):
    """``[plate.material.orthotropy]``: delta_e and delta_g, or the moduli Ex, Ey and G12 themselves.

    The transverse shear is that of the plane unless declared: as `delta_s` beside shares, as
    `transverse_shear_modulus` beside moduli, one value or two, of the planes xz and yz.
    """

    delta_e: Annotated[float | None, Field(ge=-MOST_CONTRAST, le=MOST_CONTRAST)] = None
    delta_g: Annotated[float | None, Field(ge=-0.9, le=MOST_SHEAR)] = None
    delta_s: Share | tuple[Share, Share] | None = None
    youngs_modulus_x: Annotated[float | None, Field(ge=1e6, le=1e12, description="Pa")] = None
    youngs_modulus_y: Annotated[float | None, Field(ge=1e6, le=1e12, description="Pa")] = None
    shear_modulus: Annotated[float | None, Field(ge=1e5, le=1e12, description="Pa, in the plane")] = None
    transverse_shear_modulus: Annotated[
        Modulus | tuple[Modulus, Modulus] | None, Field(description="Pa, of the planes xz and yz")
    ] = None
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
        wrong = "transverse_shear_modulus" if given[0] else "delta_s"
        if getattr(self, wrong) is not None:
            right = "delta_s, beside delta_e" if given[0] else "transverse_shear_modulus, beside shear_modulus"
            raise ValueError(f"{wrong}: of this sheet give {right}")
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
            given = self.delta_g if self.delta_s is None else self.delta_s
            transverse = _pair(given, 1.0, 1.0)
            return Orthotropy(self.delta_e, self.delta_g, angle, transverse, self.delta_s is not None)
        if self.youngs_modulus_x is None or self.youngs_modulus_y is None or self.shear_modulus is None:
            raise AssertionError("either group is complete")
        total = self.youngs_modulus_x + self.youngs_modulus_y
        delta_e = (self.youngs_modulus_y - self.youngs_modulus_x) / total
        per_isotropic = 4.0 * (1.0 + poisson_ratio) / total
        delta_g = self.shear_modulus * per_isotropic - 1.0
        if not abs(delta_e) <= MOST_CONTRAST + 1e-12:
            larger, smaller = sorted((self.youngs_modulus_x, self.youngs_modulus_y), reverse=True)
            raise ValueError(
                f"youngs_modulus_x {self.youngs_modulus_x:g} Pa, youngs_modulus_y {self.youngs_modulus_y:g} Pa: "
                f"one is {larger / smaller:.3g} times the other; allowed up to {MOST_RATIO:g} times"
            )
        if not -0.9 <= delta_g <= MOST_SHEAR:
            raise ValueError(
                f"shear_modulus {self.shear_modulus:g} Pa is {1.0 + delta_g:.3g} times an isotropic sheet's; "
                f"allowed 0.1 to {1.0 + MOST_SHEAR:g} times"
            )
        shear = self.shear_modulus if self.transverse_shear_modulus is None else self.transverse_shear_modulus
        transverse = _pair(shear, per_isotropic, 0.0)
        low, high = 1e-3, 1.0 + MOST_SHEAR
        if not low <= min(transverse) <= max(transverse) <= high:
            raise ValueError(
                f"transverse_shear_modulus {shear} Pa is {min(transverse):.3g} to {max(transverse):.3g} times an "
                f"isotropic sheet's; allowed {low:g} to {high:g} times"
            )
        return Orthotropy(delta_e, delta_g, angle, transverse, self.transverse_shear_modulus is not None)


def _pair(given: float | tuple[float, float], factor: float, more: float) -> tuple[float, float]:
    """Return one or two values times `factor` plus `more`, as two."""
    x, y = given if isinstance(given, tuple) else (given, given)
    return (factor * x + more, factor * y + more)
