"""Twins built from declarations, their reduced models taken from the cache where they are there.

====================  ===========================================================
``campaign_twin``     twins of a campaign, as declared, with effects, referred to its laws; with further sensors,
                      and a known mass
``panel_twin``        twin of a focusing panel
``warm_twin``         a panel with a field of temperatures, and the fields of a weather
``expected_modes``    modes that the twin of an updated run expects
``computed_modes``    poles and residues of a twin as an FRF shows them
====================  ===========================================================
"""
