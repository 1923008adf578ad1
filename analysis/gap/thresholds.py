"""Every threshold of the gap workflow, with its reason; fixed before a blind trial is judged."""

NODES_PER_HALF_WIDTH = 3.5
"""Number of nodes within half the width of the sharpest resonance: the error of a quintic spline through them is
2e-4 of the resonance's peak, a tenth of the noise of a node."""

LINES_PER_NODE = 1.5
"""Smallest distance of nodes, in lines: a masked mains harmonic leaves out three lines, and each node must keep
lines of its own."""

NOISE_RATIO_RANGE = (0.25, 4.0)
"""Observed over stated variance: a factor of up to two in amplitude is corrected; with a larger one the stated
noise belongs to other data."""

NOISE_RATIO_SAID = 0.1
"""A ratio of the noise's variance to the stated one further from 1 is reported: few repeats alone make it 1.02."""

STATED_SIGMA = 0.01
"""Relative standard deviation of a variance from many repeats: drift and correlation do not average out."""

NOISE_AGREES = 3.0
"""Standard deviations up to which the variances from repeats and from the scatter of neighbouring lines agree."""

NOISE_SPREAD = 2.0
"""Ratios of single sweeps that differ by more (ninth over first decile) are no common factor: refused."""

NOISE_DOF = 100
"""With fewer degrees of freedom the stated noise cannot be checked to 15 %, and is used unchecked."""

NUMERICAL_REST = 0.3
"""Numerical error of the twin, in sigma of the noise, above which absent effects would be named."""

MODEL_ERROR = 7e-4
"""Difference of two converged solvers for one plate, as a share of rms|H|: a discrepancy of this size is not
missing physics. It is an error common to all lines. On an independent solver's campaign without hidden effects the
best candidate gains 3.4 nats with it, 1.7 with 1e-3 and 6.7 with 5e-4. The estimated error of the twin of a plate
is added in squares."""

MODEL_ERROR_ALONG = 0.15
"""Share of the model error along one effect's tangent: the error is spread over many directions."""

MOVED_ERROR = 5e3
"""Second order of patches' moves, which the twin leaves out, as a share of rms|H| per square of the moves, 1/m2:
4.6 and 5.8e3 on two campaigns whose patches lay up to 0.5 mm beside their declared places."""

MOVED_ALONG = 0.3
"""As `MODEL_ERROR_ALONG`, of that error: it comes from the borders of a few patches."""

MOVES = ("patch_place", "patch_size")
"""Beginnings of the names of declared quantities that move borders of patches."""

SAME_TEMPERATURE = 0.5
"""Temperature window, K, within which readings count as one nominal temperature: ramps arrive within
tenths, steps are at least 1 K."""

READING_SIGMA = 0.05
"""Standard deviation of one oven reading, K; a sweep's temperature is the mean of two."""

Z_FLOOR = 3.0
"""Excess of chi2 in its standard deviations below which twin and data agree."""

Z_NAMED = 2.0
"""The same with effects named, which were chosen to leave little: wrong effects with a similar signal reach just
under three, the right ones leave only noise."""

WHITENESS = 5.0
"""Correlation of neighbouring whitened residuals, in its standard deviations, above which they are not noise. One
of a hundred campaigns without effects reached four; fitted parameters only lower it."""

LEAST_GAIN = 6.0
"""Smallest evidence of an effect, nats, reduced for the twin's own error: on a hundred campaigns without effects
the best candidate gained 4 at most, an effect of six sigma gains 6 to 17."""

NO_DOUBT = 100.0
"""Evidence of each effect, nats, above which effects that bring the twin down to the noise are not compared with
modes that scatter: nothing that they do not contain is imitated so well."""

NOISE_BELOW = 0.99
"""Share of noise alone that has less evidence for an unknown discrepancy than the residual of named effects, from
which this residual is not noise. One value in nats does not suit all campaigns: noise exceeds 5 nats in some per
cent of those with one ramp and three channels, in nine of ten with two ramps and two levels."""

REFITTED = 5
"""Number of candidates of a score test that are fitted in full: the right one was always in the first three."""

REFIT_SHARE = 0.9
"""A candidate that on a few temperatures gains less than this share of the best is not fitted to all: confounded
effects (cosine 0.95) gain more."""

PREDICTION_MARGIN = 4.0
"""A fit stops if it needs this many times the decrease predicted to first order to come within `REFIT_SHARE` of
the best: where shapes are fitted, the prediction is wrong by up to a factor of two."""

PAIRS_REFITTED = 3
"""Number of pairs fitted in full where no single effect explains enough."""

COARSE_TEMPERATURES = 8
"""Number of temperatures on which a candidate is first fitted; laws in between are interpolated."""

SCREENED, SCREENED_FAR = 3.0, 4
"""Excess of chi2 per number above which candidates are screened at these temperatures only: what is missing then
is a hundred sigma, and the screen of all sweeps is a third of the cost of a comparison. Number of them where it is
above `FAR`: what such a screen proposes is fitted at all of these temperatures."""

FAR = 10.0
"""Excess of chi2 per number above which declared quantities are bent by what is missing: what they come to is no
reason to release them."""

WIDENED, WIDENED_ERROR = 0.05, 0.003
"""Half-width, as a share of the frequency, by which resonances are widened where a fit leaves more than `FAR`, and
what the twin of a careful declaration does not know of the widened response, as a share of its root mean square. A
resonator of 3 g that splits modes of 0.5 % by 6 % was found at once with 0.05, and was first among the candidates
with 0.02 to 0.1; without, it was neither."""

MOVED_ELSEWHERE = 3
"""Number of candidates that are fitted from other sites, too, while none leaves less than what the twin does not
know of widened responses. A spring of 3 N/mm at a corner of 4 mm of polypropylene was found from the fifth site of
its effect, which screened third; from the first one it ended on the other side of the plate."""

LEAVES_NOISE, NEAR_IT, NEAR_MARGIN = 1.5, 3.0, 2.0
"""chi2 per number at a few temperatures up to which a candidate leaves noise, how much more than it another may
leave to be fitted on (no rival is one that leaves more), and `PREDICTION_MARGIN` for it then."""

BEHIND = 10.0
"""Times what the best candidate leaves at a few temperatures, noise included, that another may leave to be fitted
to all: where a gap is a thousand times the noise, candidates that gain 90 % of it leave a hundred."""

EXPLAINED = 0.9
"""Share of the excess that named effects must explain if more than noise is left."""

NAMED_SHARE = 0.8
"""Share of the excess over the noise that effects must explain to be named beside a discrepancy."""

LEAST_SHARE = 0.2
"""A step that explains a smaller share of the residual names a wrong effect, whatever its evidence: with a hidden
resonator a wrong effect gained 14113 nats."""

LEAST_WIDE_SHARE = 0.1
"""Share of what the twin leaves of widened responses that a candidate has to take to be fitted to the data, and
beyond the reach of which its fit is given up: the right one of three effects of one size takes a third. Where the
library lacks the cause, the best took 1 to 4 % in five minutes, and none was accepted at the data's resonances."""

MOST_EFFECTS = 6
"""Largest number of effects in one twin. Each has to take a fifth of what those before it leave, and to be missed
where it is left out again."""

SWAP_SHARE = 0.1
"""Another effect is fitted instead of an effect if its first-order evidence reaches this share of it: the error of
first order is a few per cent."""

SITES_REFITTED = 8
"""Number of sites from which an effect is fitted again beside other effects: of a spot of 94 sigma beside a taper
of 72, the right one was the sixth."""

SWAPS_REFITTED = 2
"""Number of other effects fitted instead of each effect."""

CLASS_NATS = 3.0
"""Difference in log evidence, nats (a factor of twenty), up to which candidates count as not distinguished."""

LIKELIER = 1.0
"""Nats, reduced for the twin's own error, by which another effect has to be better to be named instead: more than
fits of one set differ by. With `CLASS_NATS` a spot was named for a resonator 11 nats, 3 reduced, above it."""

CLASS_COSINE = 0.95
"""Candidates whose signal has this cosine with the best one's are confounded with it, whatever the evidence: other
model errors of a tenth could exchange them."""

LEAST_KEPT = 0.02
"""An effect is observable if this share of its tangent is independent of laws, temperatures and gain."""

LEAST_SIZE = 1.2
"""Smallest signal of one prior standard deviation, sigma: below, three of them stay under `LEAST_GAIN`."""

TEMPERATURE_OF_CONFIDENCE = 2.5
"""Divisor of differences of log evidence before the softmax: with model errors a likelihood is overconfident."""

UNLISTED = 0.05
"""Share of named effects whose true cause is in no library: known from calibration trials, not from evidence."""

LEAST_PROBABILITY = 0.8
"""Probability, against nothing and a cause of no library, below which an effect is a hint and no name. A soft
foundation that the library lacked (0.1 % of a resonance, noise of 0.04 %) was two springs, and twin and data
agreed to the noise; against both alternatives the springs had 0.75. Rivals do not count: one of them is there."""

HELD_OUT_SHARE = 0.5
"""Smallest closure on held-out data: with less, named effects fit the data but do not explain them."""

MOST_STEPS = 15
"""Largest number of linearisations of one fit; a fit that needs more does not converge."""

SETTLED = 0.1
"""Predicted decrease of chi2 at which a fit has settled: 0.05 nats."""

SETTLED_AT_FEW = 0.5
"""The same at a few temperatures, where fits are compared by tens of nats and others start from them."""

SHARPEST = 0.9
"""Nodes are placed for resonances this much sharper than the sharpest of the model updating: effects that the twin
lacks bias the loss factor upwards."""
