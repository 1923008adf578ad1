"""Verification of computed plates against exact and published natural frequencies.

====================  ================================================================
``waves``             waves of an unbounded Mindlin plate
``supports``          support conditions of an edge
``root_search``       all roots of a characteristic determinant
``exact_discs``       discs and annuli, by Bessel functions
``exact_rectangles``  rectangles with hard simple supports (Navier, Levy)
``case``              one plate with known frequencies
``exact_cases``       cases with exact solutions
``published``         benchmarks and unusual shapes, with converged solutions
``cases``             all of them
``report``            comparison of a solver's frequencies with the known ones, and order of convergence
``solids``              comparison with three-dimensional elasticity
``markdown``          the comparison as Markdown
====================  ================================================================
"""
