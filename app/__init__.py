"""Commands, files and reports: the only floor that knows everybody.

==============  =================================================================
``main``        the command line, one verb per stage
``commands``    one file per verb
``files``       campaigns, results and recordings on disk
``report``      the figures and the self-contained HTML page
``view``        the windows
==============  =================================================================
"""
