"""Commands, files and reports: the only floor that imports all others.

=================  ===========================================
``main``           the command line, one verb per stage
``commands``       one file per verb: parses, calls, prints
``stages``         one module per stage: computes, and saves
``twins``          twins built from declarations
``rig``            real and simulated rigs
``terminal``       progress, tables, records and closing lines
``files``          campaigns, results and recordings on disk
``report``         figures and the self-contained HTML page
``view``           the windows
``blind_trial``    how often the gap workflow is right
``modal_test``     tests of any laboratory, to modes
``exports``        filters as other programs take them
``sound``          sound through filters; thermometer
``studies``        the paper's studies on a panel
=================  ===========================================
"""
