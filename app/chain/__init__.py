"""The whole chain in one process: from files to the report, stages that are up to date skipped.

==================  ===================================================================
``run_chain``       stages in their order: skipped, made, failed, stopped
``work``            what is asked of a run, and what its stages share: campaign, folder, stages, options, workers;
                    SHA-256 of all that a stage reads, without reading campaigns
``links``           the stages: what each needs, reads and writes
``made_by_verbs``   results of single verbs that need not be made again
``models_ahead``    reduced models built by workers before they are needed
``found``           rows of the table at the end
==================  ===================================================================
"""
