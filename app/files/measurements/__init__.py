"""Files of other programs with signals or FRFs in them, each read into named columns.

======================  ==================================================================
``columns``             what any of them holds
``formats``             the table of formats: ending, reader, what for
``guarded``             the only way in: a reader runs in a process of its own, of bounded time and memory
``text``                CSV and other tables of text, packed with gzip too
``complex_pairs``       FRFs written as two columns each
``lvm``                 LabVIEW measurement files
``matlab``              MAT of versions 5 to 7.3
``wave``                sound files
``numpy_archive``       NPZ
``excel``               tables on the sheets of Excel's workbooks
``mdf``                 MDF of vehicle recorders
``tdms``                TDMS of any layout
``hdf5``                HDF5 and netCDF of any program
``uff_time``            time responses in universal files
======================  ==================================================================
"""
