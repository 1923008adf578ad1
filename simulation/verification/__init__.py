"""Verification of computed plates against exact and published natural frequencies.

====================  ================================================================
``exact_plates``      rectangles with hard simple supports (Navier, Levy), discs and annuli (Bessel), by waves of
                      a plate
``case``              one plate with known frequencies, and the supports of its edges; comparison of a solver's
                      frequencies with them, order of convergence; as Markdown
``cases``             cases with exact and with converged solutions, these beside published values
``solids``              comparison with three-dimensional elasticity
====================  ================================================================
"""
