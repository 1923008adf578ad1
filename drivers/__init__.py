"""The real plate: what the cards and the oven of the rig are, and how they are spoken to.

==========  ============================================================
``ni``      National Instruments cards: what each module can do
==========  ============================================================
"""
