"""Search for the effects that the twin lacks: first-order tests, full fits, comparisons.

===================  ========================================================================
``score_test``       candidates: tangents, gain inside their ranges; all of them to first order, singles and pairs
``observability``    effects that this campaign cannot show, and those that it cannot distinguish
``context``          common data of all steps, and the fits made so far
``refit``            candidates fitted in full, first on a few temperatures
``drop_and_swap``    each effect removed, and replaced by each other one
``stepwise``         effects added one by one, or as a pair; where their fits begin, and other sites for them
``held_out``         effects fitted to one part of the data and tested on the rest
``confidence``       probability of a named effect; evidence for a smooth discrepancy of no known cause
===================  ========================================================================
"""
