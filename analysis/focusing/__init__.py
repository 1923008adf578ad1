"""Spatio-temporal inverse filtering.

====================  =======================================================================
``panel``             the focusing panel as declared: plate, actuators, target, grid, filters
``grid``              the points on which a field is aimed and judged
``energy``            what filters and contrast need of the fields, as N by N forms
``inversion``         STIF: Tikhonov or truncated inverse per temperature and frequency
``rivals``            time reversal, modal control and no control
``methods``           the four ways to drive a panel, by name
``fir``               512-tap filters by inverse FFT, and what the cut costs
``performance``       contrast and spot error
``over_temperature``  filters over temperature, and one filter at all of them (paper 5.1)
``placement``         actuator positions tuned on contrast
====================  =======================================================================
"""
