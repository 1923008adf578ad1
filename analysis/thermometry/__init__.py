"""A panel as its own thermometer: temperature from what one of its patches answers while the others play.

==============  ===================================================================
``bands``       signals at the low rate that the band needs
``listening``   one stretch of drive and response; a Kalman filter over readings; simulated ones
==============  ===================================================================
"""
