"""What a plate is made of, as it is declared: ``[plate.material]``, orthotropy of a sheet in its plane included.

Ranges of E, nu and eta are those of the materials that plates are commonly made of, at -10 to 70 degrees Celsius.
The moduli are dynamic ones at audio frequencies, widened by about a tenth: a sheet whose thickness is 3 % off its
declared value shows a modulus 9 % off. The loss factors are those of a plate as it hangs in a rig, to which
patches, strings and air add: a sheet metal by itself has 1e-4, in a rig seldom less than 3e-4.

Sources: J. E. Mark (ed.), Physical Properties of Polymers Handbook, 2nd ed. (2007), and N. G. McCrum, B. E. Read,
G. Williams, Anelastic and Dielectric Effects in Polymeric Solids (1967) for moduli and loss peaks of PP, PE, PMMA,
PC, PVC, PA; J. Karger-Kocsis (ed.), Polypropylene: An A-Z Reference (1999) for PP with 20 to 40 % of short glass;
ASM Handbook vol. 1 and 2 (1990) for metals; L. Cremer, M. Heckl, B. A. T. Petersson, Structure-Borne Sound, 3rd
ed. (2005), chapter 4, for loss factors of metals and glass; EN 572-1 (2012) for soda-lime glass. Densities: the
same handbooks; W. D. Callister, Materials Science and Engineering, 8th ed. (2010), table B.1.
"""

from types import MappingProxyType
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from analysis.declaration.strict import Declared
from analysis.material import MaterialBox, Orthotropy

MOST_RATIO = 25.0
"""Largest ratio of both moduli, either way: unidirectional laminates have 10 to 20, spruce 7 to 15."""
MOST_CONTRAST = (MOST_RATIO - 1.0) / (MOST_RATIO + 1.0)
"""The same as |delta_e|."""
MOST_SHEAR = 3.0
"""Largest relative departure of a shear modulus from its isotropic value: four times it."""
ShearModulus = Annotated[float, Field(ge=1e5, le=1e12, description="Pa")]
Share = Annotated[float, Field(ge=-0.99, le=MOST_SHEAR)]


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
        ShearModulus | tuple[ShearModulus, ShearModulus] | None, Field(description="Pa, of the planes xz and yz")
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


Modulus = Annotated[float, Field(ge=1e6, le=1e12, description="Pa")]
Ratio = Annotated[float, Field(ge=0.0, lt=1.0)]
POISSON_LIMIT = 0.5
"""Below which Poisson's ratio of an isotropic sheet lies; nu of an orthotropic one, the root of nu_xy nu_yx, is
below 1, where the stiffness in the plane is no longer positive."""
Loss = Annotated[float, Field(ge=1e-5, le=1.0)]
CONSTANTS = ("youngs_modulus", "poisson_ratio", "loss_factor")
LARGEST_MODULI_RATIO = 50.0
"""Largest ratio of the moduli that a model can be made for at once."""
Kind = Literal[
    "polypropylene",
    "pp-gf",
    "polyethylene",
    "pmma",
    "abs",
    "polycarbonate",
    "pvc",
    "polyamide",
    "aluminium",
    "magnesium",
    "titanium",
    "brass",
    "copper",
    "steel",
    "glass",
]
THERMOPLASTIC = MaterialBox((0.8e9, 4.0e9), (0.30, 0.49), (0.005, 0.15))
"""What thermoplastics from a cold to a warm car interior can be, with a margin for the search."""
METAL_LOSS = (2e-4, 0.02)
"""Of plates of metal, whose mounting, patches and air lose more than the alloy itself."""
KINDS = MappingProxyType(
    {
        "polypropylene": THERMOPLASTIC,
        "pp-gf": MaterialBox((1.8e9, 11e9), (0.26, 0.47), (0.005, 0.15)),
        "polyethylene": MaterialBox((0.2e9, 2.6e9), (0.36, 0.49), (0.01, 0.25)),
        "pmma": MaterialBox((1.6e9, 7.5e9), (0.28, 0.44), (0.01, 0.16)),
        "abs": MaterialBox((1.1e9, 3.6e9), (0.32, 0.44), (0.004, 0.08)),
        "polycarbonate": MaterialBox((1.5e9, 3.3e9), (0.34, 0.43), (0.003, 0.06)),
        "pvc": MaterialBox((1.6e9, 4.8e9), (0.34, 0.45), (0.005, 0.10)),
        "polyamide": MaterialBox((0.6e9, 4.6e9), (0.34, 0.46), (0.008, 0.20)),
        "aluminium": MaterialBox((58e9, 83e9), (0.29, 0.37), METAL_LOSS),
        "magnesium": MaterialBox((36e9, 53e9), (0.26, 0.37), METAL_LOSS),
        "titanium": MaterialBox((90e9, 135e9), (0.28, 0.38), METAL_LOSS),
        "brass": MaterialBox((80e9, 130e9), (0.30, 0.39), METAL_LOSS),
        "copper": MaterialBox((100e9, 145e9), (0.31, 0.38), METAL_LOSS),
        "steel": MaterialBox((165e9, 240e9), (0.25, 0.33), METAL_LOSS),
        "glass": MaterialBox((55e9, 90e9), (0.17, 0.27), (4e-4, 0.03)),
    }
)
DENSITIES = MappingProxyType(
    {
        "polypropylene": 905.0,
        "pp-gf": 1130.0,
        "polyethylene": 950.0,
        "pmma": 1190.0,
        "abs": 1050.0,
        "polycarbonate": 1200.0,
        "pvc": 1400.0,
        "polyamide": 1140.0,
        "aluminium": 2700.0,
        "magnesium": 1770.0,
        "titanium": 4430.0,
        "brass": 8500.0,
        "copper": 8940.0,
        "steel": 7850.0,
        "glass": 2500.0,
    }
)
"""Of the unfilled material, kg/m3."""
DENSITY_RANGE = (0.5, 2.0)
"""Share of the usual density that a plate may have. Fillers make a polymer up to 1.7 times as dense (40 % of
talc: 1.4, 50 % of barium sulphate: 1.7); perforations and foam that are not declared make a plate lighter."""
ANY_DENSITY = (20.0, 25_000.0)
"""Of a plate whose kind is not declared, kg/m3."""


def density_range(kind: Kind | None) -> tuple[float, float]:
    """Return the lowest and highest density that a plate of a material may have, kg/m3."""
    if kind is None:
        return ANY_DENSITY
    low, high = DENSITY_RANGE
    return low * DENSITIES[kind], high * DENSITIES[kind]


class PlateMaterial(Declared):
    """Kind of material, or ranges of its constants over the campaign's temperatures; a range replaces the kind's.

    Attributes
    ----------
    kind : str, optional
        One of `analysis.declaration.plate_material.KINDS`.
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
