"""``flexura view``: a running campaign, and the results of a finished one. The only package that imports Qt.

==================  ===============================================================
``application``     Qt begun, or the reason why it cannot be; its garbage
``folder``          which campaign and which results a folder stands for
``theme``           dark and light
``chart``           a plot that can be read, followed and exported
``map_chart``       a plot of a map, with its colour bar; MAC of two lists of modes, with its values
``twin_page``       measured modes beside those of the twin
``cursors``         frequency and temperature that all plots share, and the frequency axis
``frf_plots``       magnitude and phase, or real and imaginary part; the Nyquist plane around the frequency cursor
``mode_table``      modes as rows of a table
``window``          keys, help, themes and export: what both windows have in common
``surface``         a field over a plate, from above or moving in perspective
``recorded``        the window on a recorded campaign
``live``            the window on a campaign being acquired
``test_run``        the window on a modal test
``opening``         which of them a folder is shown in
``screenshots``     pictures of both windows for the documentation
==================  ===============================================================
"""
