"""Parts of update and gap: a campaign set beside its twin.

=====================  ===========================================================================================
``request``            what is asked of both
``compared``           what a comparison leaves for later stages
``temperature_notes``  temperatures of a campaign that cannot be true, and drift that is not followed
``declaration_check``  declared plate on a coarse model, before its twin is built; likely reasons where that is no
                       fit
``pairing``            measured modes of some sweeps beside those of the twin
``issued_twin``        twin file that the gap stage writes
``plan``               the next experiment, and what it decided
=====================  ===========================================================================================
"""
