"""One file per verb of the command line; a verb parses, calls a stage and prints.

====================  ===================================================================
``options``           options that several verbs share; which campaigns are watched
``output``            stdout for results; stderr for progress, notes and the closing line
``bad_input``         one message and exit status 2; a picture of a geometric error
``demo``              the whole chain on three campaigns
``acquire``           run an experiment on a rig
``acquire_hammer``      the same where hits are recorded
``run``               all stages, from files to the report
``import_campaign``   import of a recording into a campaign folder
``identify``          modes
``new``               a declaration to start from
``update``            E, nu and eta
``gap``               effects that the twin lacks
``focus``             focusing filters over temperature
``compensate``        filters at any temperature
``radiation``         what a listener hears of a panel
``study``             the paper's figures on focusing
``export``            filters in the formats of other programs
``render``            sound filtered with temperature-dependent filters
``thermometer``       a panel's temperature from its own patches
``health``            what has changed on a panel since its baseline
``report``            one HTML page
``view``              windows
``watch``             a web page of running campaigns, messages
``status``            how campaigns stand, in a line
``doctor``            this computer
``check_instrument``  an instrument's driver
``safe``              bring a rig to rest
``simulate_daq``      simulated cards on a port
``blind_trial``       accuracy of the gap workflow on hidden effects
``examples``          examples copied to the current folder
``completion``        completion on the Tab key
====================  ===================================================================
"""
