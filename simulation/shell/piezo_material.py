"""Constants of a piezoceramic from data sheets, and the constants of a thin poled patch that follow."""

from dataclasses import dataclass

VACUUM_PERMITTIVITY = 8.8541878128e-12  # F/m, CODATA 2018


@dataclass(frozen=True)
class PiezoMaterial:
    """A ceramic poled through its thickness, isotropic in its plane, in plane stress.

    Attributes
    ----------
    compliance : float
        s11 at constant field, m2/N.
    poisson_ratio : float
        -s12/s11.
    d31 : float
        C/N.
    relative_permittivity : float
        Free (constant stress), through the thickness.
    density : float
        kg/m3.
    """

    compliance: float
    poisson_ratio: float
    d31: float
    relative_permittivity: float
    density: float

    def __post_init__(self) -> None:
        for name in ("compliance", "relative_permittivity", "density"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"piezo material: {name} is {getattr(self, name):g}; must be above 0")
        if not 0.0 <= self.poisson_ratio < 0.5:
            raise ValueError(f"piezo material: poisson_ratio is {self.poisson_ratio:g}; allowed 0 to 0.5")
        if self.permittivity <= 0.0:
            raise ValueError(f"piezo material: d31 {self.d31:g} C/N leaves no positive clamped permittivity")

    @property
    def youngs_modulus(self) -> float:
        """In-plane modulus at constant field, Pa."""
        return 1.0 / self.compliance

    @property
    def stiffness(self) -> tuple[float, float]:
        """Plane-stress moduli Q11 and Q12 at constant field, Pa."""
        q11 = self.youngs_modulus / (1.0 - self.poisson_ratio**2)
        return q11, self.poisson_ratio * q11

    @property
    def e31(self) -> float:
        """Plane-stress piezoelectric modulus d31/(s11 + s12), C/m2."""
        return self.d31 * self.youngs_modulus / (1.0 - self.poisson_ratio)

    @property
    def permittivity(self) -> float:
        """Through the thickness with the in-plane strain held at zero, F/m."""
        free = self.relative_permittivity * VACUUM_PERMITTIVITY
        return free - 2.0 * self.d31 * self.e31


NCE51 = PiezoMaterial(
    compliance=16e-12, poisson_ratio=0.34, d31=-195e-12, relative_permittivity=1850.0, density=7850.0
)
"""Noliac NCE51 with the constants of ``recorded-campaign/1`` (data sheet Ver1203, density as recorded)."""

PIC255 = PiezoMaterial(
    compliance=16.1e-12, poisson_ratio=0.34, d31=-180e-12, relative_permittivity=1750.0, density=7800.0
)
"""PI Ceramic PIC255, material data of the maker."""
PZT_5A = PiezoMaterial(
    compliance=16.4e-12, poisson_ratio=0.35, d31=-171e-12, relative_permittivity=1700.0, density=7750.0
)
PZT_5H = PiezoMaterial(
    compliance=16.5e-12, poisson_ratio=0.29, d31=-274e-12, relative_permittivity=3400.0, density=7500.0
)
"""D. Berlincourt, H. Krueger, C. Near: Properties of Morgan Electro Ceramic Ceramics, TP-226."""

PIEZO_MATERIALS = {"NCE51": NCE51, "PIC255": PIC255, "PZT-5A": PZT_5A, "PZT-5H": PZT_5H}
