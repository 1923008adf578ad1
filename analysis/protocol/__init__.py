"""What is to be measured, at which temperatures, and what a good measurement is.

====================  ====================================================================
``sweep``             the drive as declared, when a sweep passes its frequencies, and the voltage to be played; the
                      drive as recorded beside it; how much faster one clock is than the other
``protocol``          sweep, temperature programme and limits together, and all sweeps that follow from them
``limits``            what stops a campaign, and what makes it repeat a sweep
``objections``        why a protocol cannot be run on the hardware at hand; what may be run but makes results worse
``acceptance``        what is wrong with a sweep just recorded: overload, drive, silence, coherence; one short
                      sweep before a campaign: wiring, levels, noise and hum
====================  ====================================================================
"""
