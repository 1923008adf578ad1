"""Gap workflow: where twin and data disagree, which effect the twin lacks, and with what probability.

================  ================================================================================
``thresholds``    every threshold, with its reason
``data``          preparation of the campaign: compressed sweeps, noise, temperature groups
``fitting``       laws, readings, gain and effects fitted to all sweeps, and the residual of a fit
``search``        score tests, refits and comparison of candidates; held-out data
``imperfect``     effects named beside the scatter of resonances that no effect explains
``report``        result of the workflow
``plan``          which measurement would settle what a comparison left open
``description``   what no effect explains: where it acts, by which law
``gap``           the whole workflow, from FRFs to the report; its verdict: none, explained, partly explained or
                  unknown
================  ================================================================================
"""
