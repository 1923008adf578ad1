"""The rig as a whole: a campaign of sweeps at measured temperatures, however it is interrupted.

================  ==================================================================
``rig``           what a rig is made of, real or simulated
``rest``          the one place where it comes to rest: the oven first, then the drive
``occupancy``     one process at a time has it
``session``       from opening the rig to leaving it at rest, however that happens
``supervision``   the oven watched in a thread that nothing else can block
``end_requests``  Ctrl-C, SIGTERM, a lost terminal, a closed console: noted, then heard
``store``         what keeps the sweeps and the log, handed in
``errors``        why a campaign stopped, and what to do next
``readings``      the temperature, and whether it can be believed
``plausibility``  jumps asked again, air and plate held against each other
``station``       cards and oven as a campaign uses them: read, told, logged
``shot``          a short sweep before a campaign: wiring, levels, noise
``sweeping``      one set-point: sweeps, checks, repetition within bounds
``leg``           one ramp through its set-points
``progress``      what has been done already, read from the log
``campaign``      all legs, begun or taken up again
``simulated``     the rig with simulated cards and oven on a virtual clock
``survey``        what is connected to this computer
================  ==================================================================
"""
