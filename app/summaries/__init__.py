"""What is said of results: sentences, tables as values, and JSON records; drawn elsewhere.

=======================  ===============================================================
``table``                a table of words, as a value; a result as scripts and notebooks show it
``keywords``             the library's keywords in place of the verbs' options, in messages and notes
``modes``                modes as JSON, as tables, as rows of words and in one line; paired modes as a table
``numbers``              numbers in words: with standard deviation, times, how many sweeps
``update``               estimates of model updating as JSON, as a table and in one line; constants of an
                         orthotropic sheet likewise
``focusing``             focusing over temperature as JSON, as a table, notes and one line
``compensation``         methods of compensation, and filters in a weather, as JSON and tables
``radiation``            sound at listeners as JSON, as a table, notes and one line
``thermometer``          readings of the thermometer as JSON and in one line
``health``                what has changed on a panel as JSON, as tables and in one line
``gap``                  gap.json in words: effects, plan of the next experiment, description
``briefing``             a run in words: the plate, what its twin lacked, what to do next
=======================  ===============================================================
"""
