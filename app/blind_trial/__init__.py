"""Blind trials of the gap workflow: simulated campaigns with hidden effects, compared by the verbs' own code.

=========================  ======================================================================================
``assignments``            kind of each campaign
``plates``                 plates of random geometry, and the meshes of the simulated measurement
``experiments``            protocol, laws and electronics of one campaign
``unlisted_effects``       effects that are not in the library
``specimen``               the plate of the simulated measurement, with any effects
``effect_size``            predicted FRFs of a campaign, and the signal of an effect in them in sigma
``draw_effects``           random effects scaled to a given size
``making``                 simulation of a campaign, with small causes that nobody tells; its truth
``trial``                  all campaigns, in worker processes, resumed after a kill
``outcome``                comparison of one verdict with its truth
``proof``                  every figure of merit with its target
``planned``                trial of planned experiments: an open question, the plan, the measurement, the answer
``proof_figure``           plot of the results
=========================  ======================================================================================
"""
