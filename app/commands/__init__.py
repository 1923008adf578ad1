"""One file per verb of the command line; a verb parses, calls a stage and prints.

====================  ===================================================================
``options``           options that several verbs share
``output``            stdout for results; stderr for progress, notes and the closing line
``training_options``  how networks are trained
``bad_input``         one message and exit status 2
``fault_picture``     picture of a declaration whose geometry is wrong
``demo``              the whole chain on three campaigns
``demo_truth``        what its simulated plates are made of, and what was found
``acquire``           run an experiment on a rig
``import_campaign``   a recording into a campaign folder
``identify``          modes
``new``               a declaration to start from
``update``            E, nu and eta
``gap``               which effect the twin lacks
``focus``             focusing filters over temperature
``compensate``        filters at any temperature
``study``             the paper's figures on focusing
``export``            filters as other programs take them
``render``            sound through filters that follow the temperature
``thermometer``       a panel's temperature from its own patches
``report``            one page
``view``              windows
``doctor``            this computer
``check_instrument``  an instrument's driver
``safe``              bring a rig to rest
``simulate_daq``      simulated cards on a port
``blind_trial``       how often the gap workflow is right
``completion``        the Tab key
====================  ===================================================================
"""
