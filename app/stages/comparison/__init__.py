"""Parts of update and gap: a campaign set beside its twin.

=====================  ===========================================================================================
``compared``           what a comparison leaves for later stages, and the twin file that the gap stage writes
``temperature_notes``  temperatures of a campaign that cannot be true, and drift that is not followed
``declaration_check``  declared plate on a coarse model, before its twin is built; likely reasons where that is no
                       fit
``pairing``            measured modes of some sweeps beside those of the twin
``plan``               the next experiment, what an earlier plan left open, and what was decided
=====================  ===========================================================================================
"""
