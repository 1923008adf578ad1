"""Sound through filters that follow the temperature.

=================  =============================================================================
``following``      filters at any temperature and tilt as weighted sums of a few fixed banks; temperature over
                   time; the same in 16-bit integers
``renderer``       audio and temperature in, one signal per actuator out, by partitioned convolution; sound at
                   listeners: volts in, pascals out; contrast of the simulated field meanwhile
=================  =============================================================================
"""
