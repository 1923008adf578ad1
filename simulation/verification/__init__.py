"""Verification of computed plates against exact and published natural frequencies.

====================  ================================================================
``waves``             waves of an unbounded Mindlin plate; all roots of a characteristic determinant
``exact_plates``      rectangles with hard simple supports (Navier, Levy); discs and annuli, by Bessel functions
``case``              one plate with known frequencies, and the supports of its edges
``cases``             cases with exact and with converged solutions, these beside published values
``report``            comparison of a solver's frequencies with the known ones, order of convergence; as Markdown
``solids``              comparison with three-dimensional elasticity
====================  ================================================================
"""
