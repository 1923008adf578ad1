"""Under what circumstances a sweep is made."""

from dataclasses import dataclass

import numpy as np

from analysis.protocol.sweep import Frequencies, SweepTiming


@dataclass(frozen=True)
class SweepPoint:
    """Under what circumstances one sweep was made.

    Attributes
    ----------
    temperature : float
        Mean reading of the oven (or of the plate's own sensor), degrees Celsius.
    rate : float
        dT/dt of the oven, signed, K/s: positive on the way up.
    level : float
        Drive amplitude, V.
    source : int
        Which of the inputs drives, counted as in `analysis.experiment.Experiment.inputs`.
    timing : SweepTiming, optional
        When each frequency is passed, so that the temperature at that time is known; without it, the temperature
        is taken as steady within the sweep.
    """

    temperature: float
    rate: float
    level: float
    source: int = 0
    timing: SweepTiming | None = None

    @property
    def drifts(self) -> bool:
        """Whether the temperature at each frequency is known to differ from the sweep's mean."""
        return self.timing is not None and self.rate != 0.0

    def drift(self, frequency: Frequencies) -> Frequencies:
        """Temperature when the sweep passes frequencies (F,), Hz, less its mean, K."""
        return np.zeros_like(frequency) if self.timing is None else self.rate * self.timing.after_middle(frequency)
