"""Shear correction of a Reissner-Mindlin plate."""

SHEAR_FACTOR = 5.0 / 6.0
"""Of a parabolic distribution of the transverse shear stress over the thickness."""
