"""Modes of all sweeps of a campaign, followed over temperature.

=======================  =====================================================================================
``tracking``             modes of all sweeps, tracked over temperature
``tracks_without_twin``  tracks found in the sweeps themselves: poles of one sweep followed to the others
``expected_modes``       sweeps fitted with a twin's modes as priors, numbered as in the twin
``smooth_tracks``        smooth dependence of poles on temperature: prior of the joint fit
``joint_fit``            joint fit of poles and tracks of all sweeps, with standard deviations
``sweep_fits``           modes of every sweep from the joint fit, with their status; hidden ones added, tracks
                         without support removed
``tracked_modes``        modes of all sweeps and their tracks
``stated_temperature``   modes at the temperature stated for a sweep, where the sine passed them at another
=======================  =====================================================================================
"""
