"""What was measured on a plate over temperature: sweeps, and FRFs made of them or given.

===================  =====================================================================================
``campaign``         recorded sweeps of one experiment over temperature, their volts in units of the plate
``sweep_point``      temperature, its rate and the drive's level of one sweep
``h1``               H1 of synchronous repeats, its noise, and how far resonances move over the repeats
``noise_power``      power of the noise of an FRF at each line, with repeats or without
``frf``              FRFs of a campaign, coherence and variance per line; sweeps of one of several actuators
``frf_campaign``     FRFs of other programs in place of recorded sweeps; natural frequencies and damping over
                     temperature
``mains``            lines that mains hum takes
``grid_frequency``   frequencies that are accepted as those of the mains
===================  =====================================================================================
"""
