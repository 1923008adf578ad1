"""A panel as its own thermometer: temperature from what one of its patches answers while the others play.

==============  ===================================================================
``bands``       signals at the low rate that the band needs
``listening``   one stretch of drive and response: temperature, its standard deviation
``tracking``    readings on end: a Kalman filter of temperature and rate, and where it begins
``simulated``   what a patch answers while the temperature moves, with noise
==============  ===================================================================
"""
