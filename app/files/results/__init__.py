"""Results of a campaign or a panel: the files of a run folder.

====================  ======================================================================================
``run_folder``        where the results of one campaign gather
``run_record``        ``run.json``: stages of a run, what each was made from, seconds
``modes_file``        ``frf.h5``: FRFs of a campaign; ``modes.h5``, ``modes.csv``: identified modes
``laws_file``         ``laws.h5``: estimates per sweep, laws, FRFs of the twin; where the laws are of filters in a
                      folder of their own
``best_twin``         which of a run's laws and effects everything else uses
``pairing_json``      measured modes beside the twin's, and declared quantities, in ``laws.h5``, ``gap.json`` and
                      on the screen
``gap_json``          ``gap.json``: result of the gap workflow, for machines; plan and description in it
``gap_file``          ``gap.h5``: its figures
``next_experiment``   ``next-experiment.toml``: a planned campaign, as an experiment to be acquired
``described_effect``  what no effect explains, as an effect for a user's own folder
``twin_file``         twin files: a plate with its laws and effects; whether one belongs to a campaign
``transfers_file``    measured transfers of a panel
``panel_files``       ``filters.h5``: filters of a panel; ``compensation.h5``: filters at any temperature;
                      ``radiation.h5``: the sound that it radiates; ``studies.h5``: the paper's figures of it
====================  ======================================================================================
"""
