"""Spatio-temporal inverse filtering.

=====================  =======================================================================
``panel``              declaration of a focusing panel: plate, actuators, target, grid, filters
``measured``           a panel given by measured transfers only, and filters from them
``energy``             grid on which fields are evaluated, and their energies as N by N quadratic forms
``panel_model``        protocol of a computed panel; its responses at the temperatures of its laws, and which these
                       are
``methods``            the four ways to drive a panel, by name: STIF, time reversal, modal control, none
``design``             from complex filters to FIR taps, within the drive limits of the patches; their delay; taps
                       by least squares of the field
``fir``                taps by inverse FFT as in the paper, and the energy cut off
``performance``        contrast, level and phase, spot error, of a field and over temperature
``over_temperature``   filters over temperature, and one filter at all of them (paper 5.1)
``sound_aim``          filters chosen by what is heard: volume, pressure at listeners, zones
``pareto``             contrast against evenness of the sound
``radiated``           sound over temperature: levels, power, directivity, efficiency
``played``             response of panel and taps to a sweep in the time domain
``placement``          actuator positions optimised for contrast
=====================  =======================================================================
"""
