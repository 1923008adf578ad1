"""Model updating: the material of a twin fitted to measured FRFs, and its laws over temperature.

=====================  ==============================================================
``normal_equations``   weighted misfit of one sweep, its gradient and curvature
``coarse_look``        which modulus one sweep's resonances say, before a model is made
``start``              the start grid: no temperature may land in a neighbouring minimum
``broadening``         data as of a plate damped more: starts where resonances are sharp
``sweep_fit``          E, nu, eta and gain of one sweep, Levenberg-Marquardt
``updated``            what was found
``update``             all of it, for a campaign
``polarity``           channels recorded with the wrong sign
``strays``             sweeps that no plate explains
``laws``               smooth E(T), nu(T), eta(T) with bands from the estimates
=====================  ==============================================================
"""
