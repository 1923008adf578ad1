"""Search for the effects that the twin lacks: first-order tests, full fits, comparisons.

===================  ========================================================================
``candidate``        one candidate: its tangents, and its gain inside the ranges
``score_test``       all candidates to first order, singles and pairs
``observability``    effects that this campaign cannot show
``confounding``      effects that this campaign cannot distinguish
``context``          common data of all steps, and the fits made so far
``refit``            candidates fitted in full, first on a few temperatures
``widened_search``   where fits begin of effects that move resonances by more than their widths
``drop_and_swap``    each effect removed, and replaced by each other one
``relocation``       an effect with a place fitted again from other sites
``stepwise``         effects added one by one, or as a pair
``signatures``       the residual that each candidate alone would leave
``held_out``         effects fitted to one part of the data and tested on the rest
``unknown``          evidence for a smooth discrepancy of no known cause
``confidence``       probability of a named effect
===================  ========================================================================
"""
