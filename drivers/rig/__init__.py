"""The rig as a whole: a campaign of sweeps at measured temperatures, however it is interrupted.

==============  ====================================================================
``rig``         what a rig is made of, real or simulated
``store``       what keeps the sweeps and the log, handed in
``errors``      why a campaign stopped, and what to do next
``readings``    the temperature, and whether it can be believed
``station``     cards and oven opened, watched, and always brought to rest
``sweeping``    one set-point: sweeps, checks, repetition within bounds
``leg``         one ramp through its set-points
``progress``    what has been done already, read from the log
``campaign``    all legs, begun or taken up again
``simulated``   the rig with simulated cards and oven on a virtual clock
``survey``      what is connected to this computer
==============  ====================================================================
"""
