"""Moduli of plane stress, in which a plate's stiffness is affine."""


def plane_stress_moduli(youngs_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """C1 = E/(1 - nu**2) and C2 = nu C1, Pa: the stiffness is affine in these two."""
    c1 = youngs_modulus / (1.0 - poisson_ratio**2)
    return c1, poisson_ratio * c1
