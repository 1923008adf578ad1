"""Pairs of modes of some sweeps of a campaign, and whether the twin is a fit at all."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from analysis.pairing.assignment import ModePairs
from analysis.pairing.points import PointComparison

POOR = 0.5
"""Misfit from which a twin may be no fit; up to it, it has three quarters of the response's power."""
OVER_NOISE = 2.0
"""Ratio of the misfit to the noise from which the twin is to blame."""
LEAST_SHARE = 0.6
"""Share of the strong measured modes that a twin which fits has where and as they are. Of 13 simulated campaigns
of a polypropylene plate with a side 5 to 20 % or a patch 7 to 17 cm wrong, 0.18 to 0.50; of 51 with an effect of
the library of one, two and four times its prior, 0.85 and more wherever the misfit is `POOR`, but for orthotropy
of 10 % and more (0.33 and 0.47). On aluminium with a loss factor of 0.5 % orthotropy of 5 % and a taper of four
times its prior move modes by more than a bandwidth (0.31 and 0.50): without them that twin is no fit either, and
whether it is one with them is judged after the search."""

Source = Literal["modes.h5", "identified"]


@dataclass(frozen=True)
class PairedSweeps:
    """Measured and computed modes of some sweeps.

    Attributes
    ----------
    sweeps : tuple of ModePairs
    misfit, noise : (S,) ndarray
        Of these sweeps, shares of rms|H|.
    source : str
        ``modes.h5`` of the run folder, or ``identified`` for the comparison.
    points : PointComparison or None
        Of the shapes of all strong pairs, point by point; None for few points or modes.
    """

    sweeps: tuple[ModePairs, ...]
    misfit: NDArray[np.float64]
    noise: NDArray[np.float64]
    source: Source
    points: PointComparison | None = None

    def __post_init__(self) -> None:
        if not (self.misfit.shape == self.noise.shape == (len(self.sweeps),)):
            raise ValueError(f"misfit and noise are wanted of each of {len(self.sweeps)} sweeps")

    @property
    def failing(self) -> NDArray[np.bool_]:
        """Sweeps that the twin does not fit, (S,).

        Misfit and pairing must both fail: a lightly damped plate with a mass that nobody declared has a large
        misfit and modes that pair; modes so damped that they overlap pair by chance with some of any plate's, and
        then the misfit tells.
        """
        share = np.array([one.share for one in self.sweeps])
        poor = (self.misfit > POOR) & (self.misfit > OVER_NOISE * self.noise)
        return np.asarray(poor & ~(share >= LEAST_SHARE))  # NaN, no strong mode at all, pairs nothing

    @property
    def fits(self) -> bool:
        """Whether none of these sweeps fails."""
        return not self.failing.any()

    @property
    def worst(self) -> int:
        """The sweep of largest misfit among those that fail, or among all."""
        among = self.failing if self.failing.any() else np.ones(len(self.sweeps), dtype=bool)
        return int(np.where(among, self.misfit, -1.0).argmax())


@dataclass(frozen=True)
class Pairing:
    """Pairing of a campaign with its twin.

    Attributes
    ----------
    before : PairedSweeps
        With the updated material and no effects but those that were on from the beginning.
    after : PairedSweeps or None
        With the effects that were found, named or hints; None where none was.
    likely : str
        Likely reason where it is no fit, as tried; empty otherwise.
    wrong_declaration : bool
        Whether that reason is a declaration that makes the modes pair.
    """

    before: PairedSweeps
    after: PairedSweeps | None = None
    likely: str = ""
    wrong_declaration: bool = False

    @classmethod
    def of(cls, before: PairedSweeps | None) -> "Pairing | None":
        """Return the pairing without effects found; None where nothing could be paired."""
        return None if before is None else cls(before)

    @property
    def fits(self) -> bool:
        """Whether the twin is a fit, with the effects found or without."""
        return self.before.fits or (self.after is not None and self.after.fits)

    @property
    def wrong_points(self) -> tuple[str, ...]:
        """Sentences on sensors at wrong points or of wrong sign, by the twin with the effects found or without."""
        points = (self.after or self.before).points
        return () if points is None else points.said

    @property
    def said(self) -> str:
        """Sentence on a twin that is no fit; empty for one that is."""
        if self.fits:
            return ""
        sweep, misfit = self.before.sweeps[self.before.worst], self.before.misfit[self.before.worst]
        return (
            f"this is no fit: at {sweep.temperature:.1f} °C the twin misses {100 * misfit:.0f} % of the response, "
            f"and it has {sweep.counted}. E, nu, eta and gain are no estimates, and no effect can be named"
        )
