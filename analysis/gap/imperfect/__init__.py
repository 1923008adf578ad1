"""Names beside an imperfect twin: effects judged beside the discrepancy that no effect explains.

===================  =============================================================
``discrepancy``      scatter of resonances: how it acts on every number, its likeliest size, and the data's weights
``random_effects``   evidence of effects beside modes that scatter, all unknowns integrated out
``search``           effects added, left out and exchanged, each beside its own discrepancy; then fitted to all
                     sweeps
``naming``           which effects are named, how surely, and why; tried on modes and temperatures left out
===================  =============================================================
"""
