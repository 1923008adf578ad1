"""Twins built from declarations, their reduced models taken from the cache where they are there.

====================  ===========================================================
``campaign_twin``     twin of an experiment, as declared or with effects
``campaign_model``    twin with effects, reduced to the materials of one campaign
``panel_twin``        twin of a focusing panel
``expected_modes``    modes that an updated twin expects in every sweep
====================  ===========================================================
"""
