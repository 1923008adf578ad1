"""The window on a modal test: FRFs with what was identified laid over, and the modes with their shapes.

=================  ===========================================================
``held``           what a run of a test holds
``frf_page``       FRFs in decibels, parts or the Nyquist plane, two cursors
``modes_page``     table, stabilization chart, AutoMAC; modes dropped, added
``compared_page``  modes beside those of another run, with their MAC
``window``         the pages, the folder that is shown, and modes set beside its own
=================  ===========================================================
"""
