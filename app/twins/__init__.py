"""Twins built from declarations, their reduced models taken from the cache where they are there.

====================  ===========================================================
``campaign_twin``     twin of an experiment, as declared or with effects
``campaign_model``    twin with effects, reduced to the materials of one campaign
``scouting_twin``     the same with further sensors, and a known mass
``panel_twin``        twin of a focusing panel
``warm_twin``         the same with a temperature of its own at every place
``weather_fields``    its temperatures in a declared weather
``expected_modes``    modes that the twin of an updated run expects
``computed_modes``    poles and residues of a twin as an FRF shows them
====================  ===========================================================
"""
