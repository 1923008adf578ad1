"""What Flexura reads and writes.

==================  =======================================================================
``campaigns``       recorded campaigns, and those in Flexura's own form
``acquisition``     what a rig writes while it measures
``declarations``    what people write: experiments, tests, plates, panels
``drawings``        outlines and meshes of other programs, named in a declaration
``measurements``    signals and FRFs of other programs, one module for each format
``uff``             universal files
``results``         one module for each file of a run folder
``exports``         filters as other programs take them
``sound_file``      sound that is read (WAV, FLAC) and written (WAV)
``basis_cache``     reduced models in the user's cache
``effect_cache``    reduced plates with effects in the user's cache
``shipped``         the examples that come with the project
==================  =======================================================================

Every file:

``atomic``        whole or not there
``provenance``    what a result was made from and with
``events``        what happened, a line each
``folder_lock``   one writer at a time
``bad_file``      what is wrong with a file of results; a geometry that cannot be, and where
``disk_room``     whether results will fit, before they are begun; what is said where the disk refuses
``hdf5_file``     any HDF5 file that is read; in a process of its own by ``isolation``
``hdf5_bytes``    HDF5 without a file on the disk, and its seal
``parsed_text``   any JSON and TOML that is read
``shipped``       the examples that come with the project
``basis_cache``   reduced models in the user's cache
``effect_cache``  reduced plates with effects in the user's cache
================  ======================================================================

Campaigns:

========================  ===============================================================================
``campaign``              load any campaign: ``campaign_kind`` says which form it has
``recorded_campaign``     one as it came from the recorder: ``campaign_toml`` and ``tdms_sweep``
``campaign_folder``       one in Flexura's own form: ``sweep_file``
``campaign_inputs``       whether a result was made from the sweeps that are there now
``import_recording``      from the one to the other, surviving a kill
``acquired_campaign``     the same folder while a rig writes into it
``same_experiment``       whether it was begun with the same experiment
``running_campaign``      temperatures read and the repeat recorded last, for people; requests to the runner
``experiment_toml``       what a rig is to acquire
``hammer_experiment``     what hits are to be acquired
``hammer_folder``         a hammer test while hits are written into it
``hit_doubts``            hits whose temperature is in doubt
``instruments_toml``      the instruments that a file declares
``instrument_sections``   each of them checked by the class that its ``kind`` names
``simulation_section``    what the simulated rig is
``hidden_effects``        its effects checked against the library
``settings_toml``         any settings, their faults in the words of the file
``drawing``               outlines in DXF and SVG files: ``dxf_curves``, ``svg_curves``; and meshes of other
                          programs: ``mesh_reader`` reads them, ``exodus_mesh`` those of Exodus
``mesh_check``            a declared mesh, compared with its plate
``campaign_channels``     what is what in TDMS files of a recorder's own layout
``campaign_error``        everything that is wrong with one, in ``allowed_values``' words
``coverage``              the sweeps there against the sweeps asked for
``tdms_file``             what npTDMS only logs, or believes of a file beside
``tdms_layout``           groups, channels and lengths there against those declared
``one_actuator``          a recording of several actuators taken apart
``joined_campaign``       campaigns with an actuator each put together
``uff58``                 FRFs in universal files, read and written
``uff_file``              one opened, its numbers written as pyuff reads them; its units
``uff_geometry``          header, units, nodes and lines between them: what stands first in a universal file
``sweeps_out``            raw sweeps for other programs
``campaign_export``       FRFs of a campaign for other programs, and their names in universal files
``plate_toml``            a declared plate with FRFs or modes of other programs
========================  ===============================================================================

Measurements of other programs: ``measurements``, one module for each format; ``modal_test_toml`` declares
what they are. ``uff58`` and ``uff_modes`` write FRFs and shapes for them.

Results: ``run_folder`` holds them; ``values`` writes frozen dataclasses; ``toml_text`` writes settings:

=====================  ========================================================
``frf_file``           ``frf.h5``: FRFs of a campaign
``modes_file``         ``modes.h5``, ``modes.csv``: identified modes
``laws_file``          ``laws.h5``: estimates per sweep, laws, FRFs of the twin
``laws_elsewhere``     where the laws are of filters in a folder of their own
``best_twin``          which of a run's laws and effects everything else uses
``pairing_json``       measured modes beside the twin's, in ``laws.h5``, ``gap.json`` and on the screen
``gap_json``           ``gap.json``: result of the gap workflow, for machines
``plan_json``          the plan of the next experiment, in ``gap.json``
``next_experiment``    ``next-experiment.toml``: a planned campaign, as an experiment to be acquired
``description_json``   what no effect explains, in ``gap.json``
``described_effect``   the same as an effect for a user's own folder
``declared_json``      declared quantities as found, in ``gap.json`` and on the screen
``gap_file``           ``gap.h5``: its figures
``twin_file``          twin files: a plate with its laws and effects
``twin_check``         whether one belongs to a campaign
``panel_file``         a focusing panel
``transfers_file``     measured transfers of a panel
``filter_files``       ``filters.h5``
``compensation_file``  ``compensation.h5``
``radiation_file``     ``radiation.h5``
``run_record``         ``run.json``: stages of a run, what each was made from, seconds
``run_settings``       its options, a table of a TOML file
``studies_file``       ``studies.h5``: the paper's figures of a panel
``sound_file``         sound that is read (WAV, FLAC) and written (WAV)
``exports``            filters as other programs take them
=====================  ========================================================
=======
==================  =======================================================================
``atomic``          whole or not there
``provenance``      what a result was made from and with
``folder_lock``     one writer at a time
``disk_room``       whether results will fit, before they are begun; what is said where the disk refuses
``bad_file``        what is wrong with a file of results; a geometry that cannot be, and where
``campaign_error``  everything that is wrong with a campaign
``allowed_values``  what a settings model allows at one of its keys
``settings_toml``   any settings, their faults in the words of the file
``toml_text``       settings written as TOML that people read
``parsed_text``     any JSON and TOML that is read
``values``          frozen dataclasses in HDF5
``hdf5_file``       any HDF5 file: made without a file on the disk, and sealed; checked when it is read
``isolation``       a file read in a process of its own
==================  =======================================================================
"""
