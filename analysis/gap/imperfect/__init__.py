"""Names beside an imperfect twin: effects judged beside the discrepancy that no effect explains.

===================  =============================================================
``discrepancy``      scatter of resonances: how it acts on every number, and its likeliest size
``search``           effects added, left out and exchanged, each set beside its own discrepancy
``whole_campaign``   the twins found, fitted to all sweeps, with the standard deviations they deserve
``other_modes``      effects tried on modes, and on temperatures, that they were not fitted to
``naming``           which effects are named, how surely, and why
===================  =============================================================
"""
