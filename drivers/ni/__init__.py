"""National Instruments cards.

===========  =========================================================
``modules``  sample rates, range and resolution of the input modules
===========  =========================================================
"""
