"""Through-thickness integrals of a layer: what the shell feels of it, about the plate's mid-plane."""

from dataclasses import dataclass

SHEAR_FACTOR = 5.0 / 6.0  # Reissner's, for a parabolic shear stress over the thickness


@dataclass(frozen=True)
class Layer:
    """A homogeneous layer of uniform thickness.

    Attributes
    ----------
    thickness : float
        m.
    height : float
        z of its mid-plane above the plate's mid-plane, m.
    """

    thickness: float
    height: float = 0.0

    @property
    def moments(self) -> tuple[float, float, float]:
        """Integrals of 1, z and z**2 over the thickness: m, m2, m3."""
        t, z = self.thickness, self.height
        return t, t * z, t * z**2 + t**3 / 12.0


def patch_layer(plate_thickness: float, patch_thickness: float, side: str) -> Layer:
    """Layer of a patch glued to the ``top`` (z above 0) or ``bottom`` face of a plate."""
    height = 0.5 * (plate_thickness + patch_thickness)
    return Layer(patch_thickness, height if side == "top" else -height)


@dataclass(frozen=True)
class Elasticity:
    """Plane-stress moduli of a layer, Pa: Q11 = Q22, Q12, in-plane shear Q66, transverse shear G."""

    q11: float
    q12: float
    q66: float
    g: float

    @classmethod
    def isotropic(cls, q11: float, q12: float) -> "Elasticity":
        """Isotropic in the plane: both shear moduli follow from Q11 and Q12, linearly.

        Linearity is what makes a plate's stiffness affine in C1 = E/(1 - nu**2) and C2 = nu C1.
        """
        shear = 0.5 * (q11 - q12)
        return cls(q11, q12, shear, shear)
