"""Modal tests that are no campaign: signals or FRFs of any laboratory, to modes and shapes.

====================  ==================================================================
``declared_test``     files and channels of a declaration to FRFs
``signals``           columns of a file to checked signals in SI units, or to FRFs that it holds as such
``frf_set``           FRFs of a structure, with where they were measured
``modes_of_test``     modes and shapes of a test: computed, saved, loaded; for machines and for people
``without_windows``   what windows do to modes, taken out of them
``new_declaration``   a declaration to start from, with what is guessed for it
``guessed_channels``  roles, units and sensitivities of its channels
``edit_journal``      the journal of those changes: undo, redo
``edits``             modes dropped or added by hand, and the record of it
====================  ==================================================================
"""
