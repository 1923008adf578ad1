"""Natural frequencies and damping of a plate over temperature, as measured or as a table states them."""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Real, Whole


@dataclass(frozen=True)
class ModesAtTemperature:
    """Modes at one temperature.

    Attributes
    ----------
    temperature : float
        Degrees Celsius.
    frequency : (J,) ndarray
        Hz, ascending, of hysteretic damping: sqrt(Re k)/2 pi of the pole's k = -pole^2.
    sigma : (J,) ndarray
        Standard deviations, Hz; NaN where they are not known.
    loss_factor, sigma_loss_factor : (J,) ndarray
        Im k / Re k; NaN where they are not known.
    number : (J,) int ndarray
        Of the mode, from 1 for the lowest elastic one; 0 where it is not known.
    """

    temperature: float
    frequency: Real
    sigma: Real
    loss_factor: Real
    sigma_loss_factor: Real
    number: Whole

    def __post_init__(self) -> None:
        shape = self.frequency.shape
        for name in ("sigma", "loss_factor", "sigma_loss_factor", "number"):
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} has shape {getattr(self, name).shape}; {shape} wanted")
        if not shape[0] or not (self.frequency > 0.0).all() or (np.diff(self.frequency) < 0.0).any():
            raise ValueError(f"frequencies at {self.temperature:g} °C must ascend from above 0 Hz")
        if (self.sigma <= 0.0).any() or (self.sigma_loss_factor <= 0.0).any() or (self.loss_factor <= 0.0).any():
            raise ValueError(f"standard deviations and damping at {self.temperature:g} °C must be above 0")
