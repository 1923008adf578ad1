"""One module per stage, with a function that computes and one that saves; verbs, demo and scripts call both.

``acquire`` is one function: each sweep is saved before the next is played, so that a fault loses at most one.

=========================  ================================================================
``acquire``                an experiment run on a rig into a campaign folder
``acquire_hammer``         a hammer test recorded into a folder, hit by hit
``identify``               modes of a campaign or of single FRFs
``identify_options``       what is wanted of it
``identify_structure``     modes and mode shapes of a test or of a universal file
``comparison``             what `update` and `gap` share: pairing, checks, notes, plan
``update``                 E, nu, eta and gain of a campaign, and laws through them
``update_modes``           the same of a plate whose modes are known, without FRFs
``gap``                    comparison of a campaign with its twin
``panel``                  what stages of a panel are asked, and what they read
``focus``                  filters of a panel over temperature
``compensate``             networks and other methods that predict these filters, compared
``radiation``              sound of a panel with the filters of a run
``render``                 sound filtered as a panel would be driven while its temperature moves
``thermometer``            temperature of a panel from what one of its patches answers
``health``                 what has changed on a panel since its baseline, by campaigns or files of sound
``study``                  the paper's figures on focusing for a panel; ``study_figures``: their data, one by one
=========================  ================================================================
"""
