"""Gap workflow: where twin and data disagree, which effect the twin lacks, and how sure that is.

================  ================================================================================
``thresholds``    every threshold, with its reason
``data``          the campaign prepared: compressed sweeps, noise, temperature groups
``fitting``       laws, readings, gain and effects fitted to all sweeps, and the residual of a fit
``search``        candidates tested, refitted and compared; held-out data
``report``        the result as one value
``verdict``       none, explained, partly explained or unknown
``gap``           the whole workflow, from FRFs to the report
================  ================================================================================
"""
