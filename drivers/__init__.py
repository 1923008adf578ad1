"""The real plate: what the cards and the oven of the rig are, and how they communicate.

=================  ===================================================================
``checks``         what every driver of an instrument has to bear
``clock``          the machine's time, or a virtual one
``exclusive``      a lock that a killed process cannot leave behind
``interruptions``  signals that ask a program to end, held back while a voltage is out
``own_process``    one of our modules as a process of its own
``kinds``          kinds of instruments, our own and those of installed packages
``ni``             National Instruments cards, real and simulated
``soundcard``      a sound card as output and inputs
``ovens``          ovens and climatic chambers, real and simulated
``thermometers``   thermometers on the plate besides the cards' thermocouples
``watchdog``       supervision of the oven, in a process of its own on a real rig
``rig``            all together: campaigns of sweeps at measured temperatures
``hammer``         hammer tests: hits heard, judged and kept
=================  ===================================================================
"""
