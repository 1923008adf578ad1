"""Measured modes beside those of a twin.

=================  ====================================================================
``assignment``     modes of one sweep as they are paired, one to one; pairs of some sweeps of a campaign, and
                   whether the twin is a fit
``points``         shapes compared point by point: CoMAC, wrong signs, exchanged points, other places
``coarse_trial``   trial of another declaration on a coarse model
=================  ====================================================================
"""
