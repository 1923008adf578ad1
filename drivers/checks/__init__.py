"""What every driver of an instrument has to bear, put to anyone's driver: ``flexura check-instrument``.

======================  ==================================================================
``faulty_line``         a line between a driver and its instrument that fails as asked
``trial``               one check, and what came of it
``line_checks``         what a bad line may not do
``oven_checks``         what an oven has to bear
``thermometer_checks``  what a thermometer has to bear
``instruments``         declared ovens and thermometers, simulated or real, put on trial
``cards_checks``        what cards have to bear
``cards``               declared cards, simulated or real, put on trial
======================  ==================================================================
"""
