"""The real plate: what the cards and the oven of the rig are, and how they are spoken to.

==========  ============================================================
``clock``   the machine's time, or a virtual one
``ni``      National Instruments cards, real and simulated
``ovens``   ovens and climatic chambers, real and simulated
``rig``     both together: campaigns of sweeps at measured temperatures
==========  ============================================================
"""
