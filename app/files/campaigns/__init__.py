"""Campaigns: recorded ones, those in Flexura's own form, and the way from one to the other.

====================  =========================================================================
``loading``           any campaign, by the form that `kind` says it has
``kind``              which form of a campaign a folder has, by names alone
``recorded``          one as it came from the recorder
``channels``          ``campaign.toml``: the declaration of a recorded campaign; what is what in TDMS files of a
                      recorder's own layout; a recording of several actuators taken apart
``tdms_sweep``        one TDMS file of a recorded campaign
``tdms_file``         what npTDMS only logs, or believes of a file beside; groups, channels and lengths against
                      those declared
``of_run``            which campaign a run folder belongs to, as commands name it
``import_recording``  from a recorded campaign to a folder, surviving a kill; campaigns with an actuator each put
                      together
``folder``            one in Flexura's own form, which survives a kill at any moment; its finished sweeps
``inputs``            whether a result was made from the sweeps that are there now
``coverage``          the sweeps there against the sweeps asked for
``export``            FRFs of a campaign for other programs, and their names in universal files
``sweeps_out``        raw sweeps for other programs
====================  =========================================================================
"""
