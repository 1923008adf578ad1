"""Figures and the HTML report.

==================  ======================================================
``page``            one self-contained HTML page
``written``         all of it written, stage by stage; figures drawn side by side in worker processes
``plate_sections``  measurement, identification and updated twin on it
``panel_sections``  focusing and compensation on it, with sound to be played
``summary``         one line a stage; where results came from, and which are out of date
``style``           how figures look
``declared``        a plate as declared, and what can be drawn of a refused declaration
``measured``        FRFs, modes and updated twin over temperature (paper Figs. 7 and 9 to 12)
``pairing``         measured modes beside those of the twin
``gap``             figures of the gap
``gap_section``     the section on the gap, and what an unknown cause acts like
``focusing``        contrast and spot error (paper Figs. 4, 13, 15 and 17), and filters in a weather
``paper``           our figures beside the paper's
``modal_test``      a test at many places
``radiation``       sound at listeners, its direction, and what of the panel radiates
``sound``           contrast along a piece of sound, readings of the thermometer
``health``          a panel's health over its dates
``studies``         figures of the paper's studies, our numbers beside the paper's
==================  ======================================================
"""
