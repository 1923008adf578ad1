"""Every threshold of the gap workflow, each with its reason; frozen before a blind trial is opened."""

NODES_PER_HALF_WIDTH = 3.5
"""Nodes of the compression over half the width of the sharpest resonance: a quintic spline through them misses a
resonance by 2e-4 of its peak, a tenth of the noise of a node."""

LINES_PER_NODE = 1.5
"""Nodes never come nearer to each other than so many lines: a masked mains harmonic leaves out three lines, and
each node must keep lines of its own."""

NOISE_RATIO_RANGE = (0.25, 4.0)
"""Variance seen over variance stated: wrong by a factor of two in amplitude can be corrected, by more means that
what was stated is not this noise."""

NOISE_RATIO_SAID = 0.1
"""A ratio of seen to stated variance further than this from 1 is said: the repeats' own estimate is 2 % high."""

NOISE_SPREAD = 2.0
"""Ratios of single sweeps this many times apart (ninth over first decile) are not one wrong factor: refused."""

NOISE_DOF = 100
"""Degrees of freedom between the nodes below which the stated noise cannot be checked to 15 %: it is believed."""

NUMERICAL_REST = 0.3
"""Numerical error of the twin, in sigma of the noise, above which effects that are not there would be named."""

MODEL_ERROR = 7e-4
"""How far apart two converged solvers of one plate are, as a share of rms|H|: a discrepancy of this size is
no missing physics. It is an error common to all lines. On an independent solver's campaign that hides
nothing the best candidate brings 3.4 nats with it, 1.7 with 1e-3 and 6.7 with 5e-4. What is estimated of the
twin's own error on a plate is added to it in squares."""

MODEL_ERROR_ALONG = 0.15
"""Share of the model error that lies along any one effect's tangent: it is spread over many directions."""

SAME_TEMPERATURE = 0.5
"""Temperature window, K, within which readings count as one nominal temperature: ramps arrive within
tenths, steps are at least 1 K."""

READING_SIGMA = 0.05
"""Standard deviation of one oven reading, K; a sweep's temperature is the mean of two."""

Z_FLOOR = 3.0
"""Excess of chi2 in its standard deviations below which twin and data agree."""

Z_NAMED = 2.0
"""The same with effects named: they were chosen to leave little, and wrong effects with a similar signal
reach just under three; the right ones leave only noise."""

WHITENESS = 5.0
"""Correlation of neighbouring whitened residuals, in its standard deviations, above which they are no noise. One
null in a hundred came to four; a fit's own parameters only push it down."""

LEAST_GAIN = 6.0
"""Nats of evidence an effect must bring, the twin's own error allowed for: the best of all candidates brought 4 at
most on a hundred nulls, an effect of six sigma brings 6 to 17."""

LEAST_REST = 5.0
"""Nats of evidence for an unknown discrepancy in the residual of named effects, from which it is not noise:
right names left 4 at most, wrong ones that fitted well 6 and more."""

REFITTED = 5
"""Candidates of a screen that are fitted in full: the right one was among the first three wherever tried."""

REFIT_SHARE = 0.9
"""A candidate that on a few temperatures gains less than this share of the best is not fitted to all: confounded
effects (cosine 0.95) gain more."""

PREDICTION_MARGIN = 4.0
"""A fit that would have to gain this many times the decrease predicted to first order, to come within
`REFIT_SHARE` of the best, is given up: where shapes move, first order errs by a factor of two."""

PAIRS_REFITTED = 3
"""Pairs that are fitted in full where no single effect explains enough."""

COARSE_TEMPERATURES = 8
"""Temperatures on which a candidate is first fitted; the laws in between follow by interpolation."""

EXPLAINED = 0.9
"""Share of the excess that named effects must explain while more than noise is left."""

LEAST_SHARE = 0.2
"""A step that explains less of the residual names a wrong effect: on a hidden resonator a wrong name gained 14113
nats."""

MOST_EFFECTS = 3
"""Effects in one twin: beyond three every residual of these sizes can be explained by something."""

SWAP_SHARE = 0.1
"""A rival that to first order comes within this share of an effect's evidence is fitted in its place: first order
errs by a few per cent."""

SWAPS_REFITTED = 2
"""Rivals of each effect that are fitted in its place."""

CLASS_NATS = 3.0
"""Candidates within a factor of twenty in evidence of the winner are not told from it."""

CLASS_COSINE = 0.95
"""Candidates whose signal has this cosine with the best one's are confounded with it, whatever the evidence: other
errors of a tenth would exchange them."""

LEAST_KEPT = 0.02
"""Share of an effect's tangent that must survive the freedom of laws, temperatures and gain to be observable."""

LEAST_SIZE = 1.2
"""Size in sigma of an effect of one prior standard deviation: below, three of them stay under `LEAST_GAIN`."""

TEMPERATURE_OF_CONFIDENCE = 2.5
"""Divides differences of log evidence before the softmax: a likelihood overstates itself where models err."""

UNLISTED = 0.05
"""Share of names that stand in for a cause which is in no library: no evidence tells it, calibration trials do."""

HELD_OUT_SHARE = 0.5
"""Closure on held-out data below which named effects are a fit and no explanation."""

MOST_STEPS = 15
"""Linearisations of one fit; a fit that needs more does not converge."""

SETTLED = 0.1
"""Predicted decrease of chi2 at which a fit has settled: 0.05 nats."""

SHARPEST = 0.9
"""Nodes are laid for resonances this much sharper than the sharpest of the model updating: effects that the twin
lacks bias the loss factor upwards."""
