"""Ovens and climatic chambers: one `Oven`, four makers' controllers and whatever packages bring behind it.

=====================  ============================================================================
``oven``               what every oven can do, and the limits set-points are clamped to
``settings``           the declared oven, where its kinds are found, and ``open_oven``
``line_settings``      how an instrument on a line is reached
``controllers``        our kinds: settings, driver and simulated counterpart of each
``error``              what can go wrong, and what to do next
``expiry``             commands that end by themselves where nobody renews them
``line``               lock, gaps between commands, time-outs, bounded retries
``modbus``             Modbus registers, read back after each write, in frames of RTU and TCP
``points``             what a declared controller is made of, and its units
``registers``          declared Modbus registers
``declared_oven``      the kinds made of declared registers, or of declared queries and commands
``text_protocol``      declared queries and commands, read and set on an open line
``eurotherm``          Eurotherm 2400 and 3500, and a program of limited time in a 2400
``f4t``                Watlow F4T, and a profile of limited time in it
``votsch``             Vötsch and Weiss chambers
``espec``              Espec P-300 and SCP-220
``simulated``          the same controllers, simulated around one thermal model
=====================  ============================================================================

Driver and simulation meet in the bytes on the line only::

    oven = open_oven(WatlowSettings(kind="watlow-f4t", port="COM3", minimum=-5, maximum=65, max_rate=2))
    oven.ramp_to(60.0, 0.4)      # the controller ramps
    oven.temperature()           # the computer watches
    oven.safe()
"""
