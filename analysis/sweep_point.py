"""Under what circumstances a sweep is made."""

from dataclasses import dataclass


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
    """

    temperature: float
    rate: float
    level: float
    source: int = 0
