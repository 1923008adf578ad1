"""Blind trials of the gap workflow: campaigns with effects hidden in them, judged by what the verbs do.

=========================  ======================================================================================
``assignments``            which campaign hides what
``plates``                 plates of random geometry, and the mesh they are measured on
``experiments``            protocol, laws and electronics of one campaign
``unlisted_effects``       physics that the library has not
``specimen``               the plate that is measured, with any effects in it
``expected_frf``           FRFs that a campaign on it would give
``effect_size``            signal of an effect in sigma, once laws, readings and gain have absorbed what they can
``wanted_effects``         which effect a campaign is about, and a protocol that can show it
``draw_effects``           effects drawn and scaled to a wanted size
``making``                 a campaign recorded, its truth written elsewhere
``judging``                a campaign judged from its folder alone
``trial``                  all campaigns, in worker processes, resumed after a kill
``outcome``                one verdict beside its truth
``proportion_interval``    Wilson's interval of a proportion
``parameter_errors``       errors of the estimates, and the coverage of their intervals
``calibration``            whether stated probabilities come true
``proof``                  every figure beside its target
``proof_figure``           all of it in one picture
=========================  ======================================================================================
"""
