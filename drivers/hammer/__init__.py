"""Hammer tests: hits heard by a trigger in software, judged at once, kept and counted.

===================  ==================================================================
``trigger``          where the force leaves a level, with the samples from before
``judged_hit``       volts to units; double hits and overloads rejected; temperature of the plate
``progress``         what is measured, undone and left out
``hammer_rig``       what is asked of a rig
``campaign``         a hammer test, point by point
``simulated``        the hammer and the hand that holds it, simulated
===================  ==================================================================
"""
