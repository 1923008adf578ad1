"""Hammer tests: hits heard by a trigger in software, judged at once, kept and counted.

===================  ==================================================================
``judged_hit``       volts to units; double hits and overloads rejected; temperature of the plate; what is
                     measured, undone and left out
``hammer_rig``       what a hammer test needs: inputs, whoever holds the hammer, a store; a trigger in software
``campaign``         a hammer test, point by point
``simulated``        the hammer and the hand that holds it, simulated
===================  ==================================================================
"""
