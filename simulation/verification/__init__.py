"""What computed plates are compared with: exact and published natural frequencies.

====================  ================================================================
``waves``             waves of an unbounded Mindlin plate
``supports``          how an edge can be held
``root_search``       all roots of a characteristic determinant
``exact_discs``       discs and annuli, by Bessel functions
``exact_rectangles``  rectangles with hard simple supports (Navier, Levy)
====================  ================================================================
"""
