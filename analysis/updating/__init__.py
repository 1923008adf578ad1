"""Model updating: the material of a twin fitted to measured FRFs, and its laws over temperature.

==============  =====================================================================
``model``       what a twin must offer to be updated
``start``       the start grid: no temperature may land in a neighbouring minimum
``fit``         E, nu, eta per sweep and one gain over all of them, Gauss-Newton
``laws``        smooth E(T), nu(T), eta(T) with bands from the estimates
==============  =====================================================================
"""
