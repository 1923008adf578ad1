"""The rig as a whole: a campaign of sweeps at measured temperatures that survives interruptions.

================  ==================================================================
``rig``           parts of a rig, real or simulated
``rest``          bringing the rig to rest: the oven first, then the drive
``occupancy``     locks, so that one process at a time uses the rig
``session``       opening the rig, and bringing it to rest on every way out
``end_requests``  Ctrl-C, SIGTERM, a lost terminal, a closed console: handled later
``store``         protocol of the storage of sweeps and log, and the progress that they tell
``errors``        exceptions: why a campaign stopped, and what to do next
``readings``      temperature readings: missing or invalid ones, jumps, air against plate
``station``       cards and oven as a campaign uses them, with logging
``shot``          a short sweep before a campaign: wiring, levels, noise
``approach``      bringing the plate to a temperature
``campaign``      all legs, started or resumed; at each set-point sweeps, checks, limited repetition
``simulated``     the rig with simulated cards and oven on a virtual clock
``survey``        list of what is connected to this computer
================  ==================================================================
"""
