"""What a plate is made of, as it is declared: ``[plate.material]``."""

from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from analysis.declared import Declared
from analysis.material import MaterialBox
from analysis.material_kinds import KINDS, THERMOPLASTIC, Kind
from analysis.sheet_orthotropy import DeclaredOrthotropy, Orthotropy

Modulus = Annotated[float, Field(ge=1e6, le=1e12, description="Pa")]
Ratio = Annotated[float, Field(ge=0.0, lt=1.0)]
POISSON_LIMIT = 0.5
"""Below which Poisson's ratio of an isotropic sheet lies; nu of an orthotropic one, the root of nu_xy nu_yx, is
below 1, where the stiffness in the plane is no longer positive."""
Loss = Annotated[float, Field(ge=1e-5, le=1.0)]
CONSTANTS = ("youngs_modulus", "poisson_ratio", "loss_factor")
LARGEST_MODULI_RATIO = 50.0
"""Largest ratio of the moduli that a model can be made for at once."""


class PlateMaterial(Declared):
    """Kind of material, or ranges of its constants over the campaign's temperatures; a range replaces the kind's.

    Attributes
    ----------
    kind : str, optional
        One of `analysis.material_kinds.KINDS`.
    youngs_modulus : (float, float), optional
        Pa.
    poisson_ratio, loss_factor : (float, float), optional
        Poisson's ratio of an orthotropic sheet is the root of nu_xy nu_yx.
    orthotropy : DeclaredOrthotropy, optional
    """

    kind: Kind | None = None
    youngs_modulus: Annotated[tuple[Modulus, Modulus] | None, Field(description="Pa")] = None
    poisson_ratio: tuple[Ratio, Ratio] | None = None
    loss_factor: tuple[Loss, Loss] | None = None
    orthotropy: DeclaredOrthotropy | None = None

    @property
    def box(self) -> MaterialBox:
        """Ranges of E, nu and eta; those of a thermoplastic where they are not given."""
        known = KINDS.get(self.kind or "polypropylene", THERMOPLASTIC)
        return MaterialBox(
            self.youngs_modulus or known.youngs_modulus,
            self.poisson_ratio or known.poisson_ratio,
            self.loss_factor or known.loss_factor,
        )

    @property
    def departure(self) -> Orthotropy | None:
        """Orthotropy as a value; None for an isotropic sheet."""
        return None if self.orthotropy is None else self.orthotropy.at(float(np.mean(self.box.poisson_ratio)))

    @model_validator(mode="after")
    def _plausible(self) -> Self:
        for name in CONSTANTS:
            pair = getattr(self, name)
            if pair is not None and not pair[0] < pair[1]:
                raise ValueError(
                    f"{name} [{pair[0]:g}, {pair[1]:g}] must ascend: the lowest value, then the highest"
                )
        missing = [name for name in CONSTANTS if getattr(self, name) is None]
        if self.kind is None and missing and len(missing) < len(CONSTANTS):
            raise ValueError(f"without kind all three ranges are needed; {' and '.join(missing)} missing")
        if self.kind is None and missing and self.orthotropy is None:
            raise ValueError("empty: name a kind, or give youngs_modulus, poisson_ratio and loss_factor as ranges")
        if self.orthotropy is None and self.box.poisson_ratio[1] >= POISSON_LIMIT:
            raise ValueError(
                f"poisson_ratio [{self.box.poisson_ratio[0]:g}, {self.box.poisson_ratio[1]:g}]: allowed 0 to "
                f"below {POISSON_LIMIT:g}; up to 1 for orthotropic sheets only, as the root of nu_xy nu_yx"
            )
        low, high = self.box.youngs_modulus
        if high > LARGEST_MODULI_RATIO * low:
            raise ValueError(
                f"youngs_modulus [{low:g}, {high:g}] Pa: the higher one is {high / low:.3g} times the lower; "
                f"at most {LARGEST_MODULI_RATIO:g} times. Is one of them in another unit?"
            )
        _ = self.departure
        mean = None if self.orthotropy is None else self.orthotropy.mean_modulus
        if mean is not None and not low <= mean <= high:
            raise ValueError(
                f"orthotropy: the mean of youngs_modulus_x and youngs_modulus_y is {mean:.3g} Pa, the material's "
                f"youngs_modulus [{low:g}, {high:g}] Pa: correct one of them"
            )
        return self


def material_box(material: PlateMaterial | None) -> MaterialBox:
    """Ranges of E, nu and eta for which the twin of a plate is made: as declared, else those of thermoplastics."""
    return THERMOPLASTIC if material is None else material.box
