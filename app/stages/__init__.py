"""One module per stage, with a function that computes and one that saves; verbs, demo and scripts call both.

``acquire`` is one function: each sweep is saved before the next is played, so that a fault loses at most one.

=========================  ================================================================
``acquire``                an experiment run on a rig into a campaign folder
``acquire_hammer``         a hammer test recorded into a folder, hit by hit
``identify``               modes of a campaign or of single FRFs
``identify_options``       what is wanted of it
``identify_structure``     modes and mode shapes of a test or of a universal file
``declaration_check``      declared plate compared with one sweep, before its twin is built
``update``                 E, nu, eta and gain of a campaign, and laws through them
``update_modes``           the same of a plate whose modes are known, without FRFs
``pairing``                measured modes of some sweeps beside those of the twin
``likely_reason``          other declarations, tried where the twin is no fit
``comparison_request``     what is asked of `update` and of the next
``gap``                    comparison of a campaign with its twin
``gap_notes``                effects that were not tried, and the error of the twin
``gap_pairing``              modes paired before and after the effects found
``compared``                 what a comparison leaves for the two below
``plan``                     the next experiment
``answer``                   what an earlier comparison left open, by both campaigns
``description``              what no effect explains
``drift_notes``              drift of the temperature that is not taken into account
``temperature_notes``      temperatures of a campaign that cannot be true
``issued_twin``            twin file that the gap stage writes
``focus``                  filters of a panel over temperature
``focus_request``          what is asked of it, with laws and panel read
``compensate``             networks and other methods that predict these filters, compared
``compensate_request``     what is asked of it, with laws and panel read
``radiation``              sound of a panel with the filters of a run
``render``                 sound filtered as a panel would be driven while its temperature moves
``thermometer``            temperature of a panel from what one of its patches answers
``health``                 what has changed on a panel since its baseline
``panel_inputs``           panel, method and processor for `focus` and `compensate`
``panel_laws``             material laws of a panel's plate, and their range
``measured_plate``         a panel that is the plate that was measured
``study``                  the paper's figures on focusing for a panel; ``study_figures``: their data, one by one
=========================  ================================================================
"""
