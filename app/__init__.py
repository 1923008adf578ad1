"""Commands, files and reports: the only floor that imports all others.

=================  =====================================================================
``main``           the command line, one verb per stage
``commands``       one file per verb: parses, calls, prints
``stages``         one module per stage: computes, and saves
``twins``          twins built from declarations
``rig``            real and simulated rigs
``modal_test``     tests that are no campaign, from files to shapes
``plate_frfs``     FRFs and modes of other programs, of a declared plate
``sound``          sound files through filters, and the panel as its own thermometer
``terminal``       progress, tables on the screen, streams and signals
``summaries``      results in sentences, tables and JSON records
``files``          campaigns, results and recordings on disk
``report``         figures and the self-contained HTML page
``view``           the windows
``watch``          running campaigns seen from outside: a web page, messages
``chain``          all stages in one process, from files to the report
``fleet``          many campaigns in one command, and one report of them
``blind_trial``    how often the gap workflow is right
=================  =====================================================================
"""
