"""Many campaigns in one command, and one report of them.

=================  ========================================================================================
``fleet_run``      campaigns named, in a folder or in a list; all stages of each
``laws_beside``    laws of the pieces beside one another; which panel's filters can be used for which
``page``           ``fleet.json`` and ``fleet.html``, and the same as a table on the screen
=================  ========================================================================================
"""
