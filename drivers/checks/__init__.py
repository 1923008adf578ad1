"""What every driver of an instrument has to bear, put to anyone's driver: ``flexura check-instrument``.

======================  ==================================================================
``faulty_line``         a line between a driver and its instrument that fails as asked
``trial``               one check, and what came of it
``instruments``         what an oven or a thermometer has to bear, a bad line among it; declared ones, simulated or
                        real, put on trial
``cards``               declared cards, simulated or real, put on trial
======================  ==================================================================
"""
