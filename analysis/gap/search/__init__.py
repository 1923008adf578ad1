"""Which effects the twin lacks: tested to first order, fitted in full, compared with each other.

===================  =============================================================
``candidate``        one candidate: its tangents, and its gain inside their ranges
``score_test``       all candidates to first order, singles and pairs
``observability``    effects that this campaign cannot show
``confounding``      effects that this campaign cannot tell apart
``context``          what every step works with, and the fits made so far
``refit``            candidates fitted in full, first on a few temperatures
``drop_and_swap``    each effect removed, and replaced by each other one
``stepwise``         effects added one by one, or as a pair
``signatures``       the residual that each candidate alone would leave
``held_out``         effects fitted to one part of the data and tested on the rest
``unknown``          evidence for a smooth discrepancy of no known cause
``confidence``       probability of a named effect
===================  =============================================================
"""
