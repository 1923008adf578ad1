"""Sound through a panel's filters, and the panel as its own thermometer.

=====================  ==================================================================
``temperatures``       ``--temperature``: numbers, a way between some, or a file of readings
``rendering``          a file of sound to a file of one channel per actuator; what the panel's listeners hear
                       meanwhile, as files of sound
``trace``              field of temperatures of the panel, and the readings that filters follow; contrast of the
                       simulated field along the way
``said_of_rendering``  both as JSON, notes and one line
``listening``          the panel's temperature from what one patch answers
``stretch``            what one stretch of a recording gives, and the table of all
=====================  ==================================================================
"""
