"""The rig of an experiment, real or simulated, and what is checked before it runs.

======================  ======================================================================
``assembly``            cards and oven of an experiment, or of a hammer test, real or simulated
``simulated_rig``       the simulated ones, around the twin, and its plate in the oven
``simulated_plate``     the simulated plate, driven or hit, from the twin
``new_declarations``    an experiment and a panel to start from
``doctor``              this computer: cards, ports, oven, disk, clock; one short sweep before a campaign
======================  ======================================================================
"""
