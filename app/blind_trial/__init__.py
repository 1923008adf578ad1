"""Blind trials of the gap workflow: campaigns with something hidden in them, judged by what the verbs do.

======================  ============================================================================
``assignments``         which campaign hides what
``plates``              plates of random geometry, and the mesh they are measured on
``experiments``         protocol, laws and electronics of one campaign
``strangers``           physics that the library has not
``specimen``            the plate that is measured, with anything in it
``yardstick``           how large something is, once the rest has absorbed what it can of it
``hiding``              effects drawn and brought to size
``making``              a campaign recorded, its truth written elsewhere
``judging``             a campaign judged from its folder alone
``trial``               all campaigns, in worker processes, taken up again after a kill
``outcome``             one verdict beside its truth
``wilson``              intervals of proportions
``parameter_errors``    how far estimates are off, and whether their intervals hold
``calibration``         whether stated probabilities come true
``proof``               every figure beside its target
``proof_figure``        all of it in one picture
======================  ============================================================================
"""
