"""The window on a recorded campaign: a page for every stage whose result is there.

=================  ===========================================================
``results``        what a run holds, each file read when it is first looked at
``frf_page``       waterfall, cut along frequency, cut along temperature, Nyquist plane
``modes_page``     poles followed over temperature, and a table of them
``laws_page``      E, ν and η, and what the twin misses
``focusing_page``  contrast and spot error
``fields_page``    mode shapes and the focused field, moving
``mode_shape``     the shape of a measured mode, moving
``fields``         mode shapes from the twin, and the field of a panel's filters
``gap_page``       where twin and data disagree, and what would explain it
``window``         the pages together
=================  ===========================================================
"""
