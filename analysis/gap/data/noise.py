"""Check of the stated noise against the data, without any model.

Lines minus the splines through the nodes are noise, for any plate: the ratio of its variance to the stated one
must be 1. The stated variance comes from the repeats. These are two independent estimates of one variance. If
they agree, their weighted mean is used, because an error of a few per cent in the noise is significant over all
lines of a campaign. If they do not, the stated variance is multiplied by the ratio, and a note reports it. If the
ratio differs between sweeps, the noise is unknown and the check raises an error.

Discretisation error of a twin, and check that it is small enough to compare the twin with a campaign.

A mesh error can be mistaken for an effect: one of 0.5 to 1 % of the response was identified as an offset of the
sensor, with a log Bayes factor of 11; one of 2 to 4 % as feedthrough, with 5229.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.gap.data.compression import CompressedSweep
from analysis.gap.thresholds import (
    MODEL_ERROR,
    NOISE_AGREES,
    NOISE_DOF,
    NOISE_RATIO_RANGE,
    NOISE_RATIO_SAID,
    NOISE_SPREAD,
    NUMERICAL_REST,
    STATED_SIGMA,
)
from analysis.recordings.noise_power import SMOOTHING_LINES
from analysis.scatter import median_deviation

LEAST_FREEDOM = 0.25
"""Blocks with fewer degrees of freedom than this share of the largest scatter too much to be judged."""
SHARP = 6.0
"""Standard deviations above the median from which a block of lines holds a feature and not only noise."""
ROUGHNESS = 0.74
"""Twice the sum over k > 0 of the squared correlation between what a local quartic leaves of a line, and of the
line k further on, see `analysis.recordings.noise_power.single_repeat_power`."""


@dataclass(frozen=True)
class NoiseCheck:
    """Ratio of the noise's variance to the stated one.

    Attributes
    ----------
    ratio : (K,) ndarray
        Per channel, over all sweeps, from the scatter of neighbouring lines and, if both agree, from the repeats;
        1 where it could not be checked.
    by_sweep : (T, K) ndarray
        From the scatter of neighbouring lines alone.
    dof : int
        Degrees of freedom of all ratios together: a ratio of standard deviation s has 2 / s^2.
    sharp : (T, K, B) ndarray
        Excess chi2 of blocks of lines with features too sharp for the nodes, and so for a plate of this damping;
        zero elsewhere.
    notes : tuple of str
        Messages for the user.
    """

    ratio: NDArray[np.float64]
    by_sweep: NDArray[np.float64]
    dof: int
    sharp: NDArray[np.float64]
    notes: tuple[str, ...]

    @classmethod
    def as_stated(cls, sweeps: Sequence[CompressedSweep]) -> "NoiseCheck":
        """Take the noise as stated, unchecked."""
        local = np.array([s.chi2_within for s in sweeps])
        ones = np.ones(local.shape[:2])
        dof = sum(s.dof_within for s in sweeps) * local.shape[1]
        return cls(ones[0], ones, dof, np.zeros_like(local), ())

    def z(self, chi2: float, dof: float) -> float:
        """Excess of `chi2` over `dof` in standard deviations, the observed noise's uncertainty included."""
        inflation = 1.0 + dof / self.dof if self.dof >= NOISE_DOF else 1.0
        return float((chi2 + self.sharp.sum() - dof) / np.sqrt(2.0 * dof * inflation))


def check_noise(
    sweeps: Sequence[CompressedSweep], channels: Sequence[str], repeats_dof: NDArray[np.int_] | None = None
) -> NoiseCheck:
    """Compare stated and observed variance of every channel over all sweeps.

    Blocks of lines with a far larger ratio hold a feature (a resonator far sharper than the plate, a disturbance):
    they are left out of the mean and reported.

    Parameters
    ----------
    sweeps : sequence of CompressedSweep
    channels : sequence of str
        Names.
    repeats_dof : (T,) int ndarray, optional
        As in `analysis.recordings.frf.Frf`; without them, or if a sweep has one repeat only, only the scatter of
        neighbouring lines is used.

    Returns
    -------
    NoiseCheck

    Raises
    ------
    ValueError
        Where the ratio is too far from 1 to be corrected, or differs between sweeps.
    """
    freedom = np.array([s.block_dof for s in sweeps])[:, None, :]
    local = np.array([s.chi2_within for s in sweeps])
    dof = int(sum(s.dof_within for s in sweeps))
    if dof < NOISE_DOF:
        note = "the lines are too far apart to check the stated noise; it is used unchecked"
        ratio = np.full(local.shape[1], _expected(repeats_dof))
        return replace(NoiseCheck.as_stated(sweeps), ratio=ratio, notes=(note,))
    known = freedom[0, 0] >= LEAST_FREEDOM * freedom.max()
    quiet = np.ones(local.shape, dtype=bool)
    quiet[..., known] = ~_standing_out((local / freedom)[..., known])
    dof_seen = np.asarray((freedom * quiet).sum((0, 2)))
    seen = (local * quiet).sum((0, 2)) / dof_seen
    ratio, variance = _with_repeats(seen, 2.0 / dof_seen, repeats_dof, sweeps[0].nodes.lines.size)
    by_sweep = (local * quiet).sum(2) / np.maximum((freedom * quiet).sum(2), 1e-9)
    notes = []
    for channel, scatter, used, single in zip(channels, seen, ratio, by_sweep.T, strict=True):
        _refuse_unlike(channel, float(scatter), single, dof / len(sweeps))
        if abs(used - 1.0) > NOISE_RATIO_SAID:
            notes.append(
                f"channel {channel}: the noise is {np.sqrt(used):.2f} times the stated one "
                f"(variance x {used:.2f}); the stated variance was rescaled by it"
            )
    sharp = np.where(quiet, 0.0, local / ratio[:, None] - freedom)
    return NoiseCheck(ratio, by_sweep, round(float((2.0 / variance).sum())), sharp, tuple(notes))


def _with_repeats(
    seen: NDArray[np.float64], variance: NDArray[np.float64], repeats_dof: NDArray[np.int_] | None, lines: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Ratios (K,) `seen` between lines combined with those that the repeats give, and their relative variances.

    Not 1 is expected from the repeats, see `_expected`.
    """
    if repeats_dof is None or not repeats_dof.all():
        return seen, variance
    stated = _expected(repeats_dof)
    stated_variance = 2.0 / (lines * repeats_dof.sum()) + STATED_SIGMA**2
    agree = np.abs(seen / stated - 1.0) <= NOISE_AGREES * np.sqrt(variance + stated_variance)
    share = np.where(agree, variance / (variance + stated_variance), 0.0)
    return seen + share * (stated - seen), variance * (1.0 - share)


def _expected(repeats_dof: NDArray[np.int_] | None) -> float:
    """Return chi2 per degree of freedom with variances that were estimated, over that with exact ones.

    It is n / (n - 2) for variances of n degrees of freedom that are independent of what they weigh. Variances from
    neighbouring lines are not: each holds its own line, which takes away what n lines alone would add, but not
    that they are fewer than n for being correlated. Over hundreds of points such a per cent is ten sigma.
    """
    if repeats_dof is None or not repeats_dof.all():
        return 1.0 + ROUGHNESS / SMOOTHING_LINES
    smoothed = SMOOTHING_LINES * repeats_dof
    return float((smoothed / (smoothed - 2.0)).mean())


def _standing_out(local: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Blocks (T, K, B) far above their channel's median, relative to the scatter of the channel's blocks.

    Square roots are compared, because they scatter symmetrically about their median.
    """
    root = np.sqrt(local)
    middle = np.median(root, axis=(0, 2), keepdims=True)
    out: NDArray[np.bool_] = root > middle + SHARP * median_deviation(root, axis=(0, 2))
    return out


def _refuse_unlike(channel: str, ratio: float, by_sweep: NDArray[np.float64], dof: float) -> None:
    """Raise ValueError for a ratio out of range, or ratios that differ between sweeps with `dof` each."""
    low, high = NOISE_RATIO_RANGE
    if not low <= ratio <= high:
        raise ValueError(
            f"channel {channel}: the variance seen between neighbouring lines is {ratio:.3g} times the stated "
            f"one; {low:g} to {high:g} can be corrected. Check how the variance was estimated, and the repeats"
        )
    apart = float(np.quantile(by_sweep, 0.9) / np.quantile(by_sweep, 0.1))
    # for equal noise the ninth and the first decile are 2.6 standard deviations apart
    if apart > NOISE_SPREAD * np.exp(2.6 * np.sqrt(2.0 / max(dof, 1.0))):
        raise ValueError(
            f"channel {channel}: seen over stated variance goes from {by_sweep.min():.3g} to {by_sweep.max():.3g} "
            "between sweeps; the stated noise belongs to other data. Record the outlier sweeps again or leave "
            "them out"
        )


def carried_error(estimated: float) -> float:
    """Error of a twin common to all lines, of rms|H|: the estimated one and that between converged solvers."""
    return float(np.hypot(estimated, MODEL_ERROR))


def allowed_error(noise: float) -> float:
    """Largest estimated error of a twin, of rms|H|, with which a campaign can be compared.

    Parameters
    ----------
    noise : float
        Standard deviation of one line of a sweep, of rms|H|.

    Returns
    -------
    float
    """
    return max(MODEL_ERROR, NUMERICAL_REST * noise)


@dataclass(frozen=True)
class NumericalFloor:
    """Discretisation error of the twin, and noise, as shares of rms|H|.

    Attributes
    ----------
    error : float
        Estimated error from the truncated finite-element space and from the model reduction.
    noise : float
        Standard deviation of one line of a sweep.
    patches : bool
        Whether the plate has patches; a refusal says to check their sizes, too.
    """

    error: float
    noise: float
    patches: bool = False

    def __post_init__(self) -> None:
        parts = "plate and patches" if self.patches else "the plate"
        if self.error > allowed_error(self.noise):
            raise ValueError(
                f"the twin of this plate has an estimated error of {100 * self.error:.2g} % of the response, "
                f"{self.error / self.noise:.2f} sigma of the noise; at most {NUMERICAL_REST:g} sigma or "
                f"{100 * MODEL_ERROR:g} % allowed, or effects would be named that are not there. No finer mesh "
                "within the bound of its cost is sufficient either, and a declared mesh is not refined. Check the "
                f"sizes of {parts}, or lower protocol.band"
            )

    @property
    def carried(self) -> float:
        """Error of the twin common to all lines, as a share of rms|H|, that does not count as missing physics."""
        return carried_error(self.error)

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes for the user."""
        if self.error <= MODEL_ERROR:
            return ()
        return (
            f"the twin of this plate has an estimated error of {100 * self.error:.2g} % of the response: "
            "gaps of that size are not judged, and evidence is reduced by what this error alone could produce",
        )
