"""Design of FIR taps from complex filters, by the method that the panel declares.

The modelling delay of a method's taps is chosen here, too.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from analysis.arrays import Complex, Real
from analysis.focusing.energy import EnergyForms
from analysis.focusing.field_fir import FieldFit
from analysis.focusing.fir import FirBank, inverse_fft, suited_delay
from analysis.focusing.methods import Method, designer
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import PanelModel
from analysis.focusing.responses import constants_at, reference_temperature
from analysis.material import MaterialLaws

PENALTY_STEPS = 30
"""Steps in which the penalty on drive is raised until every patch is within its rating."""


@dataclass(frozen=True)
class TapDesign:
    """Design of the taps of one panel; prepared once, used at every temperature.

    Attributes
    ----------
    panel : Panel
    delay : int
        Modelling delay, samples.
    limits : (N,) ndarray
        Largest peak drive of each actuator for audio within ±1, V.
    fit : FieldFit or None
        None for the inverse FFT.
    """

    panel: Panel
    delay: int
    limits: Real
    fit: FieldFit | None

    @classmethod
    def of(cls, panel: Panel, delay: int) -> Self:
        """Prepare the design of a panel's filters with a modelling `delay`, samples."""
        settings = panel.filters
        fit = FieldFit.of(settings) if settings.design == "field" else None
        return cls(panel, delay, panel.limits, fit)

    def taps(self, forms: EnergyForms, filters: Complex) -> Real:
        """Taps (N, M) for `filters` (F, N) of one temperature, whose energy forms are (1, F, N, N).

        Σ|taps| is the largest voltage that audio within ±1 can cause. If it exceeds an actuator's limit, the
        penalty on that actuator's drive is raised until it does not; if that is not enough, or the aim is a sound,
        all filters are scaled down, which does not change the contrast.
        """
        settings = self.panel.filters
        if self.fit is None:
            taps = inverse_fft(filters[None], np.zeros(1), settings, self.delay).taps[0]
        else:
            weighed = forms.weighted(settings.kappa)
            weight, largest = weighed.damped(settings.tolerance)[0], weighed.largest[0]
            problem = self.fit.problem(weight, (1.0 + settings.tolerance**2) * largest, filters, self.delay)
            penalty = np.zeros(len(self.limits))
            taps = problem.solve(penalty)
            seed = settings.tolerance**2 * float(np.median(largest))
            # A penalty would change the sound at the loudest lines only; all filters scaled keep its shape.
            for _ in range(PENALTY_STEPS if settings.aim == "field" else 0):
                excess = peak_drive(taps) / self.limits
                if (excess <= 1.0).all():
                    break
                raised = np.maximum(penalty, seed) * np.maximum(1.05 * excess, 1.0) ** 2
                penalty = np.where(excess > 1.0, raised, penalty)
                taps = problem.solve(penalty)
        return np.asarray(taps / max(1.0, float((peak_drive(taps) / self.limits).max())))

    def bank(self, taps: Real, temperature: Real) -> FirBank:
        """Bank of `taps` (T, N, M) with this design's rate and delay."""
        return FirBank(taps, temperature, self.panel.filters.sample_rate, self.delay)


def fitted(filters: Complex, temperature: Real, fit: FieldFit, delay: int) -> FirBank:
    """Least-squares taps for given filters, with equal weight on all lines, for use without a field.

    Parameters
    ----------
    filters : (T, F, N) ndarray
        At the lines of `fit`, V per unit of audio signal.
    temperature : (T,) ndarray, °C
    fit : FieldFit
        Prepared with the filters' settings.
    delay : int
        Modelling delay, samples.
    """
    count, lines, actuators = filters.shape
    taps = fit.alike(filters.transpose(1, 0, 2).reshape(lines, -1), delay)
    return FirBank(taps.reshape(count, actuators, -1), temperature, fit.sample_rate, delay)


def peak_drive(taps: Real) -> Real:
    """Largest drive (...,) that a signal within ±1 can cause through `taps` (..., M): Σ|taps|."""
    peak: Real = np.abs(taps).sum(axis=-1)
    return peak


def tap_design(method: Method, model: PanelModel, panel: Panel, laws: MaterialLaws) -> TapDesign:
    """Prepare the tap design of a method, with the declared delay or a suitable one.

    A suitable delay is half the taps for STIF; for the others it is the one with most energy within the taps at
    the reference temperature.

    Parameters
    ----------
    method : str
        One of `METHODS`.
    """
    settings = panel.filters
    if method == "stif" or settings.delay is not None:
        return TapDesign.of(panel, settings.middle)
    (constants,) = constants_at(laws, np.array([reference_temperature(panel, laws)]))
    amplitude = model.amplitudes(*constants, settings.frequency)
    forms = model.space.forms([amplitude], panel.target.displacement)
    wanted = designer(method, model, panel, settings.frequency)(constants, lambda: amplitude, forms)
    return TapDesign.of(panel, suited_delay(wanted[None], settings))
