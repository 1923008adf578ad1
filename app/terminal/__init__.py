"""What is printed: progress, tables, JSON records and closing lines of the verbs.

=======================  ===============================================================
``progress``             one bar per stage on the error stream
``streams``              output that a closed pipe, a lost terminal or a full disk does not end
``end_signals``          Ctrl-C, SIGTERM and a lost terminal, all ending a verb in one way
``worker_processes``     processes that end with the one that gives them work
``campaign_progress``    the bar of a running campaign
``campaign_extent``      how many sweeps an incomplete campaign has, in a line and as JSON
``campaign_ending``      how an acquired campaign ended: record, line, exit status
``modes``                modes as JSON, as tables and in one line
``mode_rows``            modes of one sweep as rows of words
``with_sigma``           a value as far as its standard deviation lets it be known
``update``               estimates of model updating as JSON, as a table and in one line
``sheet``                constants of an orthotropic sheet likewise
``pairing``              paired modes as a table
``focusing``             focusing over temperature as JSON, as a table, notes and one line
``compensation``         methods of compensation as JSON, as a table and in one line
``radiation``            sound at listeners as JSON, as a table, notes and one line
``thermometer``          readings of the thermometer as JSON and in one line
``gap``                  tables and sentences from gap.json
``plan``                 the next experiment as a table and in sentences
``description``          what no effect explains, in sentences
``effect_words``         effects found, in units that people use
``briefing``             a run in words: the plate, what its twin lacked, what to do next
``whole_run``            stages of a run as they are done, and the table at the end
``notebook``             the same as a notebook shows them
=======================  ===============================================================
"""
