"""Sound radiated by a panel.

==================  ==========================================================================
``radiator``        pressure at listeners and far away, radiated power as a quadratic form
``spherical_head``    sound at the ears of a rigid sphere
``measures``        efficiency, directivity, level, group delay, power by the far field
==================  ==========================================================================
"""
