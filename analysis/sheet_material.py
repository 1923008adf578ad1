"""Moduli, Poisson's ratio and loss factors of an orthotropic sheet by direction, from laws and constant ratios."""

MODULI, TRANSVERSE, LOSS = "sheet_moduli", "transverse_shear", "sheet_loss"
"""Names of the declared quantities of a sheet: logarithms of ratios, see `SheetMaterial`."""
