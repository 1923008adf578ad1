"""Filters over temperature: what they reach, and what one of them reaches everywhere (paper 5.1)."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.focusing.design import TapDesign
from analysis.focusing.energy import EnergyForms, FieldSpace
from analysis.focusing.fir import FirBank, FirEnergy, energy, suited_delay
from analysis.focusing.inversion import InverseFilters, invert
from analysis.focusing.measured import MeasuredPanel
from analysis.focusing.methods import Constants, Method, MethodComparison, NoModes, PanelModel, designer
from analysis.focusing.panel import Panel
from analysis.focusing.performance import contrast, decibels, mean_response, spot_error
from analysis.material import MaterialLaws
from analysis.progress import Progress

Aimed = tuple[Real, Real, Complex]

ROBUST_STEP = 5.0
"""Largest step between the temperatures that robust filters are meant for, K: in polypropylene resonances move by
about their width in one."""


@dataclass(frozen=True)
class Aim:
    """How well a set of filters focuses, over temperature and the lines of the band.

    Attributes
    ----------
    contrast : (T, F) ndarray
        Paper eq. (9), literal.
    spot_error : (T, F) ndarray
        Share of the plate's length Lx.
    response : (T, F) ndarray
        Complex: mean displacement of the target over what was asked for, modelling delay taken out.
    """

    contrast: Real
    spot_error: Real
    response: Complex

    @property
    def level(self) -> Real:
        """Level (T, F) of the target, dB of the displacement asked for."""
        return decibels(self.response)

    @property
    def level_ripple(self) -> Real:
        """Loudest less softest line of the band (T,), dB."""
        return np.asarray(np.ptp(self.level, axis=1))

    @property
    def phase_error(self) -> Real:
        """Largest deviation of the target's phase from a pure delay in the band (T,), degrees."""
        return np.asarray(np.abs(np.angle(self.response, deg=True)).max(axis=1))


@dataclass(frozen=True)
class Answer:
    """What a panel answers at one temperature, and the filters wanted there.

    Attributes
    ----------
    amplitude : (N, F, r) ndarray
    forms, judged : EnergyForms
        For the design and for judging; they differ where transfers are measured with noise.
    wanted : (F, N) ndarray
    """

    amplitude: Complex
    forms: EnergyForms
    judged: EnergyForms
    wanted: Complex


@dataclass(frozen=True)
class Focusing:
    """Filters at some temperatures and how they focus.

    Attributes
    ----------
    method, regularisation : str
    tolerance : float
        Of the regularisation, share of the largest singular value.
    temperature : (T,) ndarray
        Degrees Celsius.
    lines : (L,) ndarray
        Where the complex filters are given, Hz: band and tapers.
    frequency : (F,) ndarray
        Lines of the band, Hz, where contrast and spot error are given.
    filters : (T, L, N) ndarray
        Complex filters, V per unit of audio signal.
    rank : (T, L) ndarray
        Singular values of H above the tolerance.
    condition : (T, L) ndarray
        Largest over smallest singular value of H.
    bank : FirBank
        The filters cut to length.
    energy : FirEnergy
        Where the uncut filters' energy lies about the taps.
    uncut, direct, fixed : Aim
        Reached with the complex filters, with the FIR filters of each temperature, and with the FIR
        filters of `reference_temperature` at every temperature.
    reference_temperature : float
        Degrees Celsius.
    target_share : float
        Area of the target over area of the plate: turns a literal contrast into the area-normalised one.
    """

    method: str
    regularisation: str
    tolerance: float
    temperature: Real
    lines: Real
    frequency: Real
    filters: Complex
    rank: NDArray[np.int64]
    condition: Real
    bank: FirBank
    energy: FirEnergy
    uncut: Aim
    direct: Aim
    fixed: Aim
    reference_temperature: float
    target_share: float

    @property
    def rank_changes(self) -> NDArray[np.int64]:
        """Lines of the band (T-1,) at which the rank differs between neighbouring temperatures.

        Under truncation R jumps there and no interpolation over temperature can follow it.
        """
        band = (self.lines >= self.frequency[0]) & (self.lines <= self.frequency[-1])
        changes: NDArray[np.int64] = np.count_nonzero(np.diff(self.rank[:, band], axis=0), axis=1)
        return changes


def focus(
    model: PanelModel,
    panel: Panel,
    laws: MaterialLaws,
    temperature: Real,
    method: Method = "stif",
    report: Progress = lambda _stage, _share: None,
    workers: int = 1,
) -> Focusing:
    """Design filters over temperature, and try those of the reference temperature everywhere.

    Parameters
    ----------
    model : PanelModel
    panel : Panel
    laws : MaterialLaws
    temperature : (T,) ndarray, °C
    method : str
        One of `METHODS`.
    report : callable
        Told the stage and the share done.
    workers : int
        Threads that design filters.

    Returns
    -------
    Focusing

    Raises
    ------
    ValueError
        For a material outside the box of the model, or a temperature outside the range of the laws.
    """
    lines, reference = panel.filters.frequency, reference_temperature(panel, laws)
    rule = designer(method, model, panel, lines)

    def answer(here: float) -> Answer:
        ((constants, amplitude),) = responses(model, laws, np.array([here]), lines)
        judged = model.space.forms([amplitude], panel.target.displacement)
        forms = robust_forms(model, panel, laws, here, judged)
        return Answer(amplitude, forms, judged, rule(constants, amplitude, forms))

    places = [partial(answer, float(here)) for here in temperature]
    kept = partial(answer, reference)
    design = tap_design(method, model, panel, laws)
    return _tried(panel, model.space, method, design, temperature, places, (reference, kept), report, workers)


def focus_measured(
    measured: MeasuredPanel,
    method: Method = "stif",
    report: Progress = lambda _stage, _share: None,
    workers: int = 1,
) -> Focusing:
    """Design filters from measured transfers, at the temperatures these were measured at.

    Parameters
    ----------
    measured : MeasuredPanel
    method : str
        One of `METHODS`.
    report : callable
        Told the stage and the share done.
    workers : int
        Threads that design filters.

    Returns
    -------
    Focusing

    Raises
    ------
    ValueError
        For modal control, which needs a model's modes.
    """
    panel, temperature = measured.panel, measured.transfers.temperature
    settings, displacement = panel.filters, panel.target.displacement
    if method == "modal-control":
        raise ValueError("modal-control needs the modes of a model; measured transfers allow the other methods")
    rule = designer(method, NoModes(measured.space), panel, settings.frequency)

    def answer(t: int) -> Answer:
        amplitude = measured.amplitudes(t)
        forms, judged = measured.forms(t, displacement)
        return Answer(amplitude, forms, judged, rule((0.0, 0.0, 0.0), amplitude, forms))

    near = measured.reference
    late = method != "stif" and settings.delay is None
    delay = suited_delay(answer(near).wanted[None], settings) if late else settings.middle
    places = [partial(answer, t) for t in range(len(temperature))]
    kept = (float(temperature[near]), places[near])
    design = TapDesign.of(panel, delay)
    return _tried(panel, measured.space, method, design, temperature, places, kept, report, workers)


def compare_measured(measured: MeasuredPanel) -> MethodComparison:
    """Contrast and spot error of every method that needs no model, at the temperature nearest to the reference."""
    panel, space = measured.panel, measured.space
    settings = panel.filters
    lines, band = settings.frequency, settings.in_band(settings.frequency)
    t = measured.reference
    amplitude = measured.amplitudes(t)
    forms, judged = measured.forms(t, panel.target.displacement)
    methods: tuple[Method, ...] = ("stif", "time-reversal", "none")
    found = []
    for method in methods:
        filters = designer(method, NoModes(space), panel, lines)((0.0, 0.0, 0.0), amplitude, forms)
        found.append(aim(space, judged, amplitude, band, filters[band], 1.0))
    contrasts, spots = np.array([one[0] for one in found]), np.array([one[1] for one in found])
    return MethodComparison(methods, (0.0, 0.0, 0.0), lines[band], contrasts, spots)


def _tried(
    panel: Panel,
    space: FieldSpace,
    method: Method,
    design: TapDesign,
    temperature: Real,
    places: Sequence[Callable[[], Answer]],
    kept: tuple[float, Callable[[], Answer]],
    report: Progress,
    workers: int,
) -> Focusing:
    """Design taps for what a panel answers at each of its `places` and judge them, beside those `kept` of one."""
    settings, lines = panel.filters, panel.filters.frequency
    band, asked = settings.in_band(lines), space.asked(panel.target.displacement)

    def heard(taps: Real) -> Complex:
        return np.asarray(design.bank(taps[None], np.zeros(1)).response(lines[band])[0])

    first = kept[1]()
    fixed_filters = heard(design.taps(first.forms, first.wanted))

    def at(place: Callable[[], Answer]) -> tuple[Complex, Real, InverseFilters, list[Aimed]]:
        here = place()
        taps = design.taps(here.forms, here.wanted)
        plant = invert(here.forms, settings.tolerance, settings.regularisation)
        tried = (here.wanted[band], heard(taps), fixed_filters)
        aims = [aim(space, here.judged, here.amplitude, band, one, asked) for one in tried]
        return here.wanted, taps, plant, aims

    found = []
    with ThreadPoolExecutor(workers) as pool:
        for done, one in enumerate(pool.map(at, places), start=1):
            found.append(one)
            report("Filters", done / len(temperature))
    every = np.array([one[0] for one in found])
    uncut, direct, fixed = (joined([one[3][kind] for one in found]) for kind in range(3))
    return Focusing(
        method=method,
        regularisation=settings.regularisation,
        tolerance=settings.tolerance,
        temperature=temperature,
        lines=lines,
        frequency=lines[band],
        filters=every,
        rank=np.array([one[2].rank[0] for one in found]),
        condition=np.array([one[2].condition[0] for one in found]),
        bank=design.bank(np.array([one[1] for one in found]), temperature),
        energy=energy(every, settings, design.delay),
        uncut=uncut,
        direct=direct,
        fixed=fixed,
        reference_temperature=kept[0],
        target_share=space.grid.target_share,
    )


def robust_forms(
    model: PanelModel, panel: Panel, laws: MaterialLaws, temperature: float, forms: EnergyForms
) -> EnergyForms:
    """Energy forms for a design where a thermometer may err.

    The mean over T ± `thermometer_error` in equal steps, both ends included: the filters that follow from it make
    the mean squared error of the field smallest over these temperatures. An error that is as likely at the ends as
    in the middle counts them more than a uniform one does, and it is at the ends that lines fail.

    Parameters
    ----------
    model : PanelModel
    panel : Panel
    laws : MaterialLaws
    temperature : float
        T, °C.
    forms : EnergyForms
        Those of T alone; returned where the panel declares no error.

    Returns
    -------
    EnergyForms
        Of one temperature.
    """
    width = panel.filters.thermometer_error
    if width == 0.0:
        return forms
    steps = 2 * int(np.ceil(width / ROBUST_STEP))
    around = np.clip(temperature + np.linspace(-width, width, steps + 1), *laws.temperature_range)
    amplitudes = (amplitude for _, amplitude in responses(model, laws, around, panel.filters.frequency))
    found = model.space.forms(amplitudes, panel.target.displacement)
    mean = [part.mean(axis=0, keepdims=True) for part in (found.plate, found.target, found.aim)]
    return EnergyForms(*mean)


def tap_design(method: Method, model: PanelModel, panel: Panel, laws: MaterialLaws) -> TapDesign:
    """How a method's filters become taps, with the delay declared or else the one that suits the method.

    That is half the taps for STIF, and for the others where the taps hold most of their energy, judged at the
    reference temperature.

    Parameters
    ----------
    method : str
        One of `METHODS`.
    model : PanelModel
    panel : Panel
    laws : MaterialLaws

    Returns
    -------
    TapDesign
    """
    settings = panel.filters
    if method == "stif" or settings.delay is not None:
        return TapDesign.of(panel, settings.middle)
    (constants,) = constants_at(laws, np.array([reference_temperature(panel, laws)]))
    amplitude = model.amplitudes(*constants, settings.frequency)
    forms = model.space.forms([amplitude], panel.target.displacement)
    wanted = designer(method, model, panel, settings.frequency)(constants, amplitude, forms)
    return TapDesign.of(panel, suited_delay(wanted[None], settings))


def aim(
    space: FieldSpace,
    forms: EnergyForms,
    amplitude: Complex,
    band: NDArray[np.bool_],
    filters: Complex,
    asked: float,
) -> Aimed:
    """Contrast, spot error and response of filters in the band of one temperature.

    Parameters
    ----------
    space : FieldSpace
    forms : EnergyForms
        Of this temperature, at all lines.
    amplitude : (N, L, r) ndarray
        Generalised coordinates of this temperature, at all L lines.
    band : (L,) ndarray of bool
        The F lines of the band.
    filters : (F, N) ndarray
        On the lines of the band.
    asked : float
        φᵀ W φ (`FieldSpace.asked`), m4.

    Returns
    -------
    Aimed
        Three arrays (F,).
    """
    within = forms.at(slice(None), band)
    spot = spot_error(space, amplitude[:, band], filters)
    return contrast(within, filters)[0], spot, mean_response(within, filters, asked)[0]


def joined(rows: list[Aimed]) -> Aim:
    """One `Aim` of what `aim` found at each temperature."""
    contrasts, spots, responded = (np.array(part) for part in zip(*rows, strict=True))
    return Aim(contrasts, spots, responded)


def responses(
    model: PanelModel, laws: MaterialLaws, temperature: Real, frequency: Real
) -> Iterator[tuple[Constants, Complex]]:
    """Material and answer of a panel, one temperature after the other.

    Parameters
    ----------
    model : PanelModel
    laws : MaterialLaws
    temperature : (T,) ndarray, °C
    frequency : (F,) ndarray, Hz

    Yields
    ------
    (float, float, float)
        E, Pa, nu and eta.
    (N, F, r) complex ndarray
        Generalised coordinates per volt or newton of every actuator.

    Raises
    ------
    ValueError
        For a material outside the box of the model.
    """
    for constants in constants_at(laws, temperature):
        yield constants, model.amplitudes(*constants, frequency)


def constants_at(laws: MaterialLaws, temperature: Real) -> list[Constants]:
    """E (Pa), nu and eta at each `temperature` (T,), °C."""
    material = laws.at(temperature)
    rows = zip(material.youngs_modulus, material.poisson_ratio, material.loss_factor, strict=True)
    return [(float(e), float(nu), float(eta)) for e, nu, eta in rows]


def covered(laws: MaterialLaws, wanted: tuple[float, float]) -> tuple[float, float]:
    """Return the part of the `wanted` range the laws cover, °C; ValueError if they do not meet."""
    low, high = max(laws.temperature_range[0], wanted[0]), min(laws.temperature_range[1], wanted[1])
    if low >= high:
        raise ValueError(
            f"the laws hold from {laws.temperature_range[0]:g} to {laws.temperature_range[1]:g} °C, the panel is "
            f"wanted from {wanted[0]:g} to {wanted[1]:g} °C: nothing in common"
        )
    return low, high


def reference_temperature(panel: Panel, laws: MaterialLaws) -> float:
    """Return the panel's reference temperature, moved to the end of the laws' range where it lies outside, °C."""
    low, high = covered(laws, panel.filters.operating_range)
    return min(max(panel.filters.reference_temperature, low), high)


def spaced(low: float, high: float, spacing: float) -> Real:
    """Temperatures in even steps, and the upper end itself.

    Parameters
    ----------
    low, high : float
        Ends, °C.
    spacing : float
        K.

    Returns
    -------
    (T,) ndarray, °C
        Ascending.
    """
    steps = np.arange(low, high + 1e-9, spacing)
    return steps if high - steps[-1] < 1e-6 * spacing else np.append(steps, high)
