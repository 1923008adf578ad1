"""Sound through filters that follow the temperature.

=================  =============================================================================
``following``      filters at any temperature as weighted sums of a few fixed banks
``tilt_bank``      what a tilt of the panel's temperature adds to them
``fixed_point``    the same in 16-bit integers
``convolution``    uniformly partitioned convolution
``renderer``       audio and temperature in, one signal per actuator out
``programme``      temperature over time
``heard``          sound at listeners: volts in, pascals out
``field``          contrast of the simulated field meanwhile
=================  =============================================================================
"""
