"""A panel whose temperature is a field that moves: what is lost by filters that know it at a few places only.

====================  ==============================================================
``declared_weather``  the surroundings of a panel, and its thermometers: a ``weather/1`` file
``family``            temperatures of filters from the readings of thermometers; protocol of a panel with a field;
                      filters for a family of fields: robust, or following a tilt
``judged``            temperatures over time, and contrast and level lost in them; how that is found, by what is
                      known of the field
====================  ==============================================================
"""
