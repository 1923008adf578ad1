"""Model updating: the material of a twin fitted to measured FRFs, and its laws over temperature.

=======================  =======================================================================
``normal_equations``     weighted misfit of one sweep, its gradient and curvature; E, nu, eta and gain of one
                         sweep, Levenberg-Marquardt
``start``                rough modulus from one sweep's resonances, before a twin is built; start values from a
                         grid, to avoid wrong local minima; of data transformed to more damping
``sheet_start``          start values of an orthotropic sheet's moduli and losses
``update``               all sweeps of a campaign, by the estimator of `analysis.gap.fitting`; channels recorded
                         with the wrong sign
``laws``                 smooth E(T), nu(T), eta(T) with bands from the estimates
``modes_fit``            the same from natural frequencies and damping, without FRFs
``drift``                change of FRFs by the drift of the temperature within sweeps
``corrected_twin``       laws and FRFs of a twin with known effects
=======================  =======================================================================
"""
