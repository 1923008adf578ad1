"""Spatio-temporal inverse filtering.

=====================  =======================================================================
``panel``              the focusing panel as declared: plate, actuators, target, grid, filters
``target``             what is to be moved: rectangle, ellipse, polygon, several
``measured``           a panel known by its measured transfers alone
``grid``               the points on which a field is aimed and judged
``energy``             what filters and contrast need of the fields, as N by N forms
``inversion``          STIF: Tikhonov or truncated inverse per temperature and frequency
``rivals``             time reversal, modal control and no control
``panel_model``        what is asked of a panel that can be computed
``methods``            the four ways to drive a panel, by name
``design``             from filters wanted to taps played, within what the patches bear
``field_fir``          taps by least squares of the field
``prolate``            the few combinations of taps with energy in a band
``fir``                taps by inverse FFT as in the paper, and what the cut costs
``performance``        contrast, level and phase, spot error
``over_temperature``   filters over temperature, and one filter at all of them (paper 5.1)
``temperatures``       those that laws and panel share, and steps over them
``responses``          what a panel answers there, alone and where a thermometer may err
``aim``                contrast, spot error and response over temperature
``tap_delay``          the delay that suits a method
``measured_filters``   filters over temperature of measured transfers
``local_models``       a panel in the few coordinates that some kelvins need
``played``             a sweep through taps and panel in the time domain
``modal_integration``  modes integrated step by step
``placement``          actuator positions tuned on contrast
=====================  =======================================================================
"""
