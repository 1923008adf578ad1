"""What computed plates are compared with: exact and published natural frequencies.

====================  ================================================================
``waves``             waves of an unbounded Mindlin plate
``supports``          how an edge can be held
``root_search``       all roots of a characteristic determinant
``exact_discs``       discs and annuli, by Bessel functions
``exact_rectangles``  rectangles with hard simple supports (Navier, Levy)
``case``              one plate whose frequencies are known
``exact_cases``       those known exactly
``published``         benchmarks and odd shapes, from converged solutions
``cases``             all of them
``report``            a solver's frequencies beside the known ones, with their order
``markdown``          the same as text
====================  ================================================================
"""
