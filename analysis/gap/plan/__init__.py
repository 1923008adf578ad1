"""The next experiment: what a comparison left open, and which measurement would settle it per hour.

=====================  ===============================================================================
``separation``         what a campaign says about some effects, all else eliminated; what is open: which of two
                       effects, or whether one is there; distance of the answers in standard deviations
``measurement``        candidate campaigns and tools in the hand, with their hours, and the sweeps they would give
``decision``           measurements by expected separation per hour; which of two effects it was, by two campaigns
=====================  ===============================================================================
"""
