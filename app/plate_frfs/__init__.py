"""FRFs that another program estimated, of a plate that ``plate.toml`` declares: files to a campaign.

==================  ==================================================================
``given_campaign``  the declaration and all its files to a campaign of FRFs
``source_files``    FRFs of one file, of any format that is read, ``frf.h5`` too; temperature, direction and level
                    of an FRF
``channel_map``     which drive and which sensor an FRF belongs to; a roving hammer
``plate_of_modes``  the same of a plate whose natural frequencies are known; natural frequencies and damping from a
                    table
``new_plate``       a declaration to start from
==================  ==================================================================
"""
