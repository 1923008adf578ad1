"""Which poles are modes of the plate, and which lines say nothing about them.

================  =============================================================================================
``status``        which poles are modes of the plate, and why the others are not; lines disturbed by mains
                  harmonics or other tones
``resolution``    pairs of poles that the frequency resolution cannot separate
``leakage``       leakage of windowed segments, taken out of modes
``confirmation``  modes found again with other bands, lines or channels, in neighbouring sweeps, without single
                  hits
================  =============================================================================================
"""
