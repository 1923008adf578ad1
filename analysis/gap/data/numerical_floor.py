"""Discretisation error of a twin, and check that it is small enough to compare the twin with a campaign.

A mesh error can be mistaken for an effect: one of 0.5 to 1 % of the response was identified as an offset of the
sensor, with a log Bayes factor of 11; one of 2 to 4 % as feedthrough, with 5229.
"""

from dataclasses import dataclass

import numpy as np

from analysis.gap.thresholds import MODEL_ERROR, NUMERICAL_REST


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
