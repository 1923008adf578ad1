"""The next experiment: what a comparison left open, and which measurement would settle it per hour.

=====================  ===============================================================================
``question``           what is open: which of two effects, or whether an effect is there
``information``        what a campaign says about some effects, all else eliminated
``separation``         distance between two answers, in standard deviations
``planned_sweeps``     sweeps of a campaign that was not made, with the noise of one that was
``measurement``        candidate campaigns and tools in the hand, with their hours
``decision``           which of two effects it was, by two campaigns
``ranking``            measurements by expected separation per hour
=====================  ===============================================================================
"""
