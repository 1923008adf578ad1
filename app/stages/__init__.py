"""One module per stage: one half computes, the other saves; verbs, demo, blind trial and scripts call the same.

``acquire`` is one function: each sweep is saved before the next is played, so that no fault costs more than one.

=========================  ================================================================
``acquire``                an experiment run on a rig into a campaign folder
``identify``               modes of a campaign or of single FRFs
``identify_structure``     modes and shapes of a test or of a universal file
``declaration_check``      declared plate compared with one sweep, before its twin is built
``update``                 E, nu, eta and gain of a campaign, and laws through them
``gap``                    a campaign compared with its twin
``issued_twin``            twin file that the gap stage writes
``focus``                  filters of a panel over temperature
``compensate``             networks and their rivals, trained on these filters and judged
``panel_inputs``           panel, method and processor for `focus` and `compensate`
``panel_laws``             laws that a panel's plate obeys, and their range
``study``                  the paper's figures on focusing for a panel
``uncorrected_filters``    loss of filters that were designed without a named effect
=========================  ================================================================
"""
