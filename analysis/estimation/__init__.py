"""From signals of any test to FRFs: spectra, estimators, hammer tests, what a record is too short for.

=========================  ==================================================================
``quantities``             force, acceleration, pressure, ...: units, and the names of their ratios
``sampling``               sample rates, by times or steps, and the error that their digits leave
``windows``                windows over segments, force and exponential windows, and what those do to poles
``spectra``                signals of one run, checked; auto and cross spectra of all channels, from segments or
                           blocks; blows, periods, bursts, sweeps or noise, and the segments that fit them
``estimators``             H1, H2 and Hv with coherence and variance, of one drive or several; a variance from the
                           coherence that came with an FRF; what windowed segments make of a resonance
``impacts``                blows found in a recording, and why some of them do not count
``agreement``              whether runs, and weak and strong drives, that are averaged measured one and the same
                           FRF
``ringing``                responses that still ring where their record ends
``transfer``               one FRF between two places
=========================  ==================================================================

The sweeps of a campaign are estimated by ``analysis.recordings.h1``: periodic, without window or leakage.
"""
