"""Poles and residues of FRFs, tracked over temperature.

=========================  ==================================================================
``automatic``              identification of FRFs with common poles: search, model order, status; the paper's own
                           recipe: local peaks, then wide-band refinement
``settings``               limits of the search, band, residual terms, mains frequency
``finishing``              final model order by `order`, last fit on all lines, errors at the peaks, status
``modes``                  poles, residues and residual terms of one sweep, frequency and damping of a pole;
                           synthesis of its FRFs; distribution of the modes' damping ratios, used as a prior
``judgement``              which poles are modes of the plate
``over_temperature``       modes of all sweeps, followed over temperature
``pole_residue``           the model: columns, derivatives, synthesis; terms for modes outside the band; poles as
                           parameters
``measured``               measured FRFs of one condition, their variances or noise from a residual; a few sums of
                           many for the search
``lines``                  measured lines with their weights, and sums over them; a running median along them
``averaging``              fewer lines for the search
``pole_search``            least squares over the poles alone, residues eliminated: misfit, gradient, Hessian; the
                           triangular factor; the search
``vector_fitting``         start poles without an initial guess
``order``                  how many poles: backward elimination by BIC, its penalty for one pole; residual terms
``missing``                poles found in the residual and added; one pole replaced by two close ones
=========================  ==================================================================
"""
