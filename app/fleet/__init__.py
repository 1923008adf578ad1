"""Many campaigns in one command, and one report of them.

=================  ========================================================================================
``members``        which campaigns: named, in a folder, or in a list
``fleet_run``      all stages of each, by one executor; models that several need are made first
``laws_beside``    laws of the pieces beside one another: scatter, outliers, pieces known at few temperatures
``exchange``       contrast that each panel's filters have on each other
``record``         what ``fleet.json`` holds
``page``           ``fleet.html``, and the table on the screen
=================  ========================================================================================
"""
