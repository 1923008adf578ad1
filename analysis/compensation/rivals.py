"""What networks are compared with: filters computed at every temperature, interpolation and principal filters.

The former, the reference, come from local models: a panel reduced to the coordinates of its responses within a few
kelvins.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any, Self

import numpy as np
from numpy.polynomial.chebyshev import chebinterpolate, chebvander
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.compensation.network import LowRankBank
from analysis.compensation.outcome import LINEAR, LOW_RANK, REDUCED_FREQUENCY, RIGIDITY_SPLINE, SPLINE
from analysis.focusing.design import FieldFit, fitted, tap_design
from analysis.focusing.energy import EnergyForms
from analysis.focusing.fir import FirBank
from analysis.focusing.methods import Method, designer
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import Constants, PanelModel, constants_at, design_forms
from analysis.focusing.sound_aim import SoundAim
from analysis.material import MaterialLaws
from analysis.progress import Progress


@dataclass(frozen=True)
class DirectFilters:
    """Filters computed at T temperatures, and the energy forms and models to assess others there.

    Attributes
    ----------
    bank : FirBank
        Filters (T, N, M).
    forms : EnergyForms
        Of the F lines of the band, at every temperature.
    models : sequence of PanelModel
        T local models of the panel, each reduced to the coordinates needed near its temperature.
    """

    bank: FirBank
    forms: EnergyForms
    models: Sequence[PanelModel]


MODEL_RANGE, MODEL_STEP = 10.0, 5.0
"""Range of one local model, and spacing of the temperatures it is made from, K."""

LARGEST_ENERGY_LEFT_OUT = 1e-10
"""Largest share of the energy of all normalised responses in the coordinates left out."""

LARGEST_MODEL_ERROR = 5e-4
"""Largest relative error of a local response between these temperatures: half the twin's own tolerance."""

FEWEST_TEMPERATURES = 20
"""Smallest number of temperatures in a window for which a local model saves time."""


def local_models(
    model: PanelModel,
    constants: Callable[[Real], Sequence[Constants]],
    temperature: Real,
    lines: Real,
    margin: float,
    pool: Executor,
) -> list[PanelModel]:
    """Return a model for each temperature: the full one, or the local one of a window with many temperatures.

    Parameters
    ----------
    constants : callable
        From temperatures (n,), °C, to E, nu and eta at each.
    temperature : (T,) ndarray, °C
    lines : (F,) ndarray, Hz
        Where it will be evaluated.
    margin : float
        Largest distance from its temperature at which each will be evaluated, K.
    pool : Executor
        Computes the models in parallel.

    Returns
    -------
    list of PanelModel
        T of them; those of one window are the same.
    """
    low, high = temperature.min(), temperature.max()
    last = max(int(np.ceil((high - low) / MODEL_RANGE)) - 1, 0)
    windows = np.minimum((temperature - low) // MODEL_RANGE, last).astype(int)
    made: dict[int, Callable[[], PanelModel]] = {}
    for window in np.unique(windows):
        here = temperature[windows == window]
        if len(here) >= FEWEST_TEMPERATURES:
            coldest, hottest = here.min() - margin, here.max() + margin
            nodes = np.linspace(coldest, hottest, int(np.ceil((hottest - coldest) / MODEL_STEP)) + 1)
            between = 0.5 * (nodes[1:] + nodes[:-1])
            job = partial(local_model, model, constants(nodes), constants(between), lines)
            made[int(window)] = pool.submit(job).result
    found = {window: result() for window, result in made.items()}
    return [found.get(int(window), model) for window in windows]


def local_model(
    model: PanelModel, made_from: Sequence[Constants], tried_at: Sequence[Constants], lines: Real
) -> PanelModel:
    """Reduce a model to the principal coordinates of its responses at some materials.

    They are the principal coordinates of all responses at the materials it is made from, each of unit length
    (proper orthogonal decomposition). Their number grows until responses at other materials are accurate.

    Parameters
    ----------
    made_from : sequence of (float, float, float)
        E, nu and eta.
    tried_at : sequence of (float, float, float)
        Materials at which the error is checked.
    lines : (F,) ndarray, Hz

    Returns
    -------
    PanelModel
        `model` itself where the error of fewer coordinates exceeds `LARGEST_MODEL_ERROR` or they save nothing.
    """
    some = lines[np.unique(np.linspace(0, len(lines) - 1, 64).astype(int))]
    gram = sum(_gram(model, one, some) for one in made_from)
    values, vectors = np.linalg.eigh(gram)
    rest = np.cumsum(np.maximum(values, 0.0)) / values.sum()
    for kept in (LARGEST_ENERGY_LEFT_OUT, 0.1 * LARGEST_ENERGY_LEFT_OUT):
        basis = vectors[:, rest > kept]
        if basis.shape[1] > 0.8 * len(vectors):
            break
        local = model.restricted(basis)
        if max(_error(model, local, basis, one, some) for one in tried_at) <= LARGEST_MODEL_ERROR:
            return local
    return model


def _gram(model: PanelModel, constants: Constants, lines: Real) -> NDArray[np.float64]:
    """Sum (r, r) of a aᵀ over real and imaginary parts of all responses, each of unit length."""
    answers = model.amplitudes(*constants, lines)
    answers = answers / np.linalg.norm(answers, axis=-1, keepdims=True)
    flat = answers.reshape(-1, answers.shape[-1])
    gram: NDArray[np.float64] = flat.real.T @ flat.real + flat.imag.T @ flat.imag
    return gram


def _error(model: PanelModel, local: PanelModel, basis: Real, constants: Constants, lines: Real) -> float:
    """Largest relative error of any response at one material."""
    whole = model.amplitudes(*constants, lines)
    missed = whole - local.amplitudes(*constants, lines) @ basis.T
    return float((np.linalg.norm(missed, axis=-1) / np.linalg.norm(whole, axis=-1)).max())


def direct_filters(
    model: PanelModel,
    panel: Panel,
    laws: MaterialLaws,
    temperature: Real,
    method: Method = "stif",
    report: Progress = lambda _stage, _share: None,
    workers: int = 1,
    stage: str = "Filters everywhere",
) -> DirectFilters:
    """FIR filters computed at every temperature, and the energy forms of the band there.

    Parameters
    ----------
    temperature : (T,) ndarray, °C
    method : str
        How the filters are designed.
    report : callable
        Called with the stage and the share done.
    workers : int
        Threads that design filters.
    stage : str
        Name under which progress is reported.

    Raises
    ------
    ValueError
        For a material outside the box of the model.
    """
    lines = panel.filters.frequency
    band = panel.filters.in_band(lines)
    design, error = tap_design(method, model, panel, laws), panel.filters.thermometer_error

    sound = SoundAim.designing(panel, model.space.grid, method)
    plates = constants_at(laws, temperature)

    def known(around: Real) -> list[Constants]:
        return constants_at(laws, np.clip(around, *laws.temperature_range))

    def at(t: int) -> tuple[Real, EnergyForms]:
        local = local_to[t]
        constants = plates[t]
        form = local.forms(*constants, lines, panel.target.displacement)
        wanted = design_forms(local, panel, laws, float(temperature[t]), form, sound)
        # Its lowest modes may lie below all lines, where the coordinates of a local model are not checked.
        own = model if method == "modal-control" else local
        filters = designer(method, own, panel, lines)(
            constants, partial(local.amplitudes, *constants, lines), wanted
        )
        return design.taps(wanted, filters), form.at(slice(None), band)

    taps, forms = [], []
    with ThreadPoolExecutor(workers) as pool:
        local_to = local_models(model, known, temperature, lines, error, pool)
        for done, (tap, form) in enumerate(pool.map(at, range(len(temperature))), start=1):
            taps.append(tap)
            forms.append(form)
            report(stage, done / len(temperature))
    return DirectFilters(design.bank(np.array(taps), temperature), EnergyForms.joined(forms), local_to)


Predictor = Callable[[FirBank, Real], Real]


def linear(filters: FirBank, temperature: Real) -> Real:
    """Taps (T, N, M) on straight lines between neighbouring training temperatures."""
    knots = filters.temperature
    place = np.clip(np.searchsorted(knots, temperature, side="right") - 1, 0, len(knots) - 2)
    share = np.clip((temperature - knots[place]) / (knots[place + 1] - knots[place]), 0.0, 1.0)[:, None, None]
    taps: Real = (1.0 - share) * filters.taps[place] + share * filters.taps[place + 1]
    return taps


def cubic_spline(filters: FirBank, knots: Real, places: Real) -> Real:
    """Taps on a cubic not-a-knot spline of each tap; beyond the knots, those of the nearest end.

    Parameters
    ----------
    filters : FirBank
        At the n training temperatures.
    knots : (n,) ndarray
        Abscissae of the training filters: temperatures, °C, or log √D(T), with which log frequencies change
        linearly, so that the spline is smoother.
    places : (T,) ndarray
        Abscissae at which taps are computed, of the same kind.

    Returns
    -------
    (T, N, M) ndarray
        Taps, V per unit of audio signal.
    """
    from scipy.interpolate import CubicSpline

    ascending = np.argsort(knots)
    low, high = knots[ascending[0]], knots[ascending[-1]]
    spline = CubicSpline(knots[ascending], filters.taps[ascending], axis=0)
    taps: Real = spline(np.clip(places, low, high))
    return taps


def log_root_rigidity(youngs_modulus: Real, poisson_ratio: Real) -> Real:
    """Return log √D up to a constant, with the bending stiffness D = E h³/12/(1 - ν²)."""
    u: Real = 0.5 * np.log(youngs_modulus / (1.0 - poisson_ratio**2))
    return u


def reduced_frequency(filters: FirBank, knots: Real, places: Real, frequency: Real) -> Complex:
    """Complex responses (T, F, N) interpolated at equal reduced frequency f/√D, modelling delay taken out.

    A plate of stiffness D responds at f as one of stiffness D' does at f √(D'/D), D'/D times as much, if ν, η and
    the patches' share are equal. At equal reduced frequency resonances coincide; the remaining change is
    interpolated over four neighbours.

    Parameters
    ----------
    filters : FirBank
        At the training temperatures; their responses can be computed at any frequency.
    knots, places : (n,) and (T,) ndarray
        log √D at the training and at the wanted temperatures.
    frequency : (F,) ndarray, Hz

    Returns
    -------
    (T, F, N) complex ndarray
        Responses of the filters wanted.
    """
    ascending = np.argsort(knots)
    knots = knots[ascending]
    width, places = min(4, len(knots)), np.clip(places, knots[0], knots[-1])
    firsts = np.clip(np.searchsorted(knots, places) - width // 2, 0, len(knots) - width)
    reach = np.exp(knots[-1] - knots[0])
    series = _Series.of(filters, frequency[0] / reach, frequency[-1] * reach)
    result = np.empty((len(places), len(frequency), filters.taps.shape[1]), dtype=complex)
    for t, (place, first) in enumerate(zip(places, firsts, strict=True)):
        stencil = slice(first, first + width)
        stretch = np.exp(knots[stencil] - place)
        near = series.at(ascending[stencil], frequency * stretch[:, None])
        result[t] = np.tensordot(_lagrange(knots[stencil], place) / stretch**2, near, axes=1)
    return result


def _lagrange(points: Real, place: float) -> Real:
    """Weights (n,) at a `place` of values at `points` (n,), for the polynomial through them."""
    own = np.eye(len(points), dtype=bool)
    shares = np.where(own, 1.0, place - points) / np.where(own, 1.0, points[:, None] - points)
    return np.asarray(shares.prod(axis=1))


@dataclass(frozen=True)
class _Series:
    """Chebyshev series of the responses of a bank at n temperatures over a range of frequencies.

    Attributes
    ----------
    middle, half : float
        Of the range, Hz.
    coefficients : (n, d, 2 N) ndarray
        Of the real parts, then of the imaginary ones.
    """

    middle: float
    half: float
    coefficients: Real

    @classmethod
    def of(cls, filters: FirBank, low: float, high: float) -> Self:
        middle, half = 0.5 * (low + high), 0.5 * (high - low) or 1.0  # one line alone: any range will do
        # The last tap's phase turns by so many radians over half the range, and its series needs little more
        # terms: Bessel functions fall below rounding ten cube roots beyond their argument.
        reach = max(filters.delay, filters.taps.shape[2] - filters.delay)
        turned = 2.0 * np.pi * half * reach / filters.sample_rate
        count = int(np.ceil(turned + 10.0 * np.cbrt(turned + 1.0)))

        def responses(points: Real) -> Any:  # NumPy's types know of numbers only, its code of arrays as well
            found = filters.response(middle + half * points).swapaxes(0, 1)
            return np.concatenate([found.real, found.imag], axis=2).reshape(len(points), -1)

        coefficients = chebinterpolate(responses, count - 1).reshape(count, len(filters.taps), -1)
        return cls(middle, half, coefficients.swapaxes(0, 1))

    def at(self, which: NDArray[np.intp], frequency: Real) -> Complex:
        """Responses (k, F, N) at the temperatures `which` (k,), each at frequencies of its own (k, F), Hz."""
        terms = chebvander((frequency - self.middle) / self.half, self.coefficients.shape[1] - 1)
        real, imaginary = np.split(terms @ self.coefficients[which], 2, axis=2)
        return np.asarray(real + 1j * imaginary)


def plain_rivals() -> dict[str, Predictor]:
    """Methods without laws, by name: taps (T, N, M) from filters and temperatures (T,), °C."""
    return {
        LINEAR: linear,
        SPLINE: lambda bank, temperature: cubic_spline(bank, bank.temperature, temperature),
        LOW_RANK: lambda bank, temperature: LowRankBank.of(bank).taps(temperature),
    }


def rivals(panel: Panel, laws: MaterialLaws) -> dict[str, Predictor]:
    """All methods, by name: taps (T, N, M) from filters and temperatures (T,), °C."""

    def u(temperature: Real) -> Real:
        return rigidity(laws, temperature)

    def rigidity_spline(bank: FirBank, temperature: Real) -> Real:
        return cubic_spline(bank, u(bank.temperature), u(temperature))

    lines, fit = panel.filters.frequency, FieldFit.of(panel.filters)

    def equal_reduced_frequency(bank: FirBank, temperature: Real) -> Real:
        wanted = reduced_frequency(bank, u(bank.temperature), u(temperature), lines)
        return fitted(wanted, temperature, fit, bank.delay).taps

    return plain_rivals() | {RIGIDITY_SPLINE: rigidity_spline, REDUCED_FREQUENCY: equal_reduced_frequency}


def rigidity(laws: MaterialLaws, temperature: Real) -> Real:
    """Return log √D (T,) of a plate at `temperature` (T,), °C."""
    material = laws.at(temperature)
    return log_root_rigidity(material.youngs_modulus, material.poisson_ratio)
