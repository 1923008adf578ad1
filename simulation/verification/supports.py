"""Support conditions of a plate's edge, and the quantities that vanish there."""

from typing import Literal

Support = Literal["free", "clamped", "soft", "hard"]
"""``soft``: w = 0; ``hard``: the rotation along the edge too; ``clamped``: w and both rotations."""

CONDITIONS: dict[Support, tuple[str, str, str]] = {
    "free": ("shear force", "bending moment", "twisting moment"),
    "clamped": ("deflection", "rotation across", "rotation along"),
    "soft": ("deflection", "bending moment", "twisting moment"),
    "hard": ("deflection", "bending moment", "rotation along"),
}
"""Quantities that vanish at an edge."""
RIGID_FREQUENCY = 0.02
"""Frequency w a**2 sqrt(rho h / D) below which a motion counts as rigid."""
