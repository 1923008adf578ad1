"""The rig as a whole: a campaign of sweeps at measured temperatures that survives interruptions.

================  ==================================================================
``rig``           parts of a rig, real or simulated
``occupancy``     locks, so that one process at a time uses the rig
``session``       a rig in use, brought to rest on every exit: the oven first, then the drive
``end_requests``  requests to end the program, acted on where stopping is safe; why a campaign stopped
``store``         protocol of the storage of sweeps and log, and the progress that they tell
``readings``      temperature readings: missing or invalid ones, jumps, air against plate
``station``       cards and oven together, with logging; the plate brought to a temperature
``shot``          a short sweep before a campaign: wiring, levels, noise
``campaign``      all legs, started or resumed; at each set-point sweeps, checks, limited repetition
``simulated``     the rig with simulated cards and oven on a virtual clock
``survey``        list of what is connected to this computer
================  ==================================================================
"""
