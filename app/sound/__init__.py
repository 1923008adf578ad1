"""Sound through a panel's filters, and the panel as its own thermometer.

=================  ==================================================================
``temperatures``   ``--temperature``: numbers, a way between some, or a file of readings
``rendering``      a file of sound to a file of one channel per actuator
``trace``          contrast of the simulated field along the way
``listening``      the temperature of a panel while it plays
=================  ==================================================================
"""
