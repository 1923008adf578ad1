"""The gap workflow: where twin and data disagree, which effect the twin lacks, and how sure that is.

====================  ===============================================================================
``compression``       a sweep as a few hundred independent numbers, nothing lost
``noise``             the stated noise checked without a model
``numerical_floor``   what discretisation does to the twin, and whether that can be borne
``groups``            sweeps at one temperature share the laws there
``sweeps``            a campaign ready to be compared
``state``             laws, readings, gain and effects: the point a fit moves
``normal_equations``  whitened least squares of every sweep
``arrow``             all sweeps together, what is a group's own eliminated
``fit``               all of it fitted together
``gap_fit``           where it ended
``screen``            score test of every candidate at once, singles and pairs
``observability``     what this campaign cannot see
``look_alikes``       what it cannot tell apart
``whiteness``         whether a residual is noise
``unknown``           the nameless competitor
``refit``             candidates fitted in full
``search``            stepwise, each step accepted on the residual
``challenge``         drop-one and swap tests of what was found
``held_out``          the gap on data that took no part
``misfit``            relative misfit over the lines
``where``             the residual over all a campaign varies
``signatures``        what each candidate alone would leave of it
``confidence``        how sure a name is
``verdict``           none, explained, partly explained or unknown
``gap``               from FRFs to a report
``report``            what was found
``thresholds``        every threshold, with its reason
====================  ===============================================================================
"""
