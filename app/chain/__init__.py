"""The whole chain in one process: from files to the report, stages that are up to date skipped.

==================  ===================================================================
``run_chain``       stages in their order: skipped, made, failed, stopped
``request``         what is asked of a run: campaign, folder, stages, options
``work``            what the stages of one run share: campaign, folder, workers
``links``           the stages: what each needs, reads and writes
``input_files``     SHA-256 of all that a stage reads, without reading campaigns
``made_by_verbs``   results of single verbs that need not be made again
``models_ahead``    reduced models built by workers before they are needed
``found``           rows of the table at the end
==================  ===================================================================
"""
