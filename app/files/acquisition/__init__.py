"""Files that a rig writes while it measures.

====================  ==================================================================================
``campaign_folder``   a campaign folder while a rig writes into it
``same_experiment``   whether a folder was begun with the same experiment
``hammer_folder``     a hammer test while hits are written into it; hits whose temperature is in doubt
``events``            what happened, a line each; temperatures read and the repeat recorded last, for people;
                      requests to the runner
====================  ==================================================================================
"""
