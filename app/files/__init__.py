"""What Flexura reads and writes.

==================  =======================================================================
``campaigns``       recorded campaigns, and those in Flexura's own form
``acquisition``     what a rig writes while it measures
``declarations``    what people write: experiments, tests, plates, panels
``drawings``        outlines and meshes of other programs, named in a declaration
``measurements``    signals and FRFs of other programs, one module for each format
``uff``             universal files
``results``         the files of a run folder
``exports``         filters as other programs take them
``sound_file``      sound that is read (WAV, FLAC) and written (WAV)
``basis_cache``     reduced models in the user's cache
``effect_cache``    reduced plates with effects in the user's cache
``shipped``         the examples that come with the project
==================  =======================================================================

Every file:

==================  =======================================================================
``atomic``          whole or not there: one file, or all that are written together
``provenance``      what a result was made from and with
``folder_lock``     one writer at a time
``disk_room``       whether results will fit, before they are begun; what is said where the disk refuses
``bad_file``        what is wrong with a file of results; a geometry that cannot be, and where
``campaign_error``  everything that is wrong with a campaign
``allowed_values``  what a settings model allows at one of its keys
``settings_toml``   any settings, their faults in the words of the file; settings written as TOML that people read
``parsed_text``     any JSON and TOML that is read
``hdf5_file``       any HDF5 file: made without a file on the disk, and sealed; checked when it is read; frozen
                    dataclasses in it
``isolation``       a file read in a process of its own
==================  =======================================================================
"""
