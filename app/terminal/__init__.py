"""The terminal: progress, tables, streams and signals.

=======================  ===============================================================
``progress``             one bar per stage on the error stream, or in a notebook
``tables``               tables as the terminal draws them
``streams``              output that a closed pipe, a lost terminal or a full disk does not end
``end_signals``          Ctrl-C, SIGTERM and a lost terminal, all ending a verb in one way
``engine``                 --workers or --cluster: the executor that takes independent tasks
``cluster``                workers of a Dask cluster, checked before they work
``campaign``             the bar of a running campaign, and how it ended: record, line, exit status; a hammer test:
                         which hit is asked for, what came of it; keys pressed
``whole_run``            stages of a run as they are done, and the table at the end
=======================  ===============================================================
"""
