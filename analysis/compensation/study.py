"""The compensation put to the test: every method at every quarter of a degree (paper 5.3 and 5.4)."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from analysis.arrays import Real
from analysis.compensation.burden import burdens
from analysis.compensation.interpolation import cubic_spline, linear, log_root_rigidity, reduced_frequency
from analysis.compensation.knots import place_temperatures
from analysis.compensation.leave_one_out import left_out_networks, left_out_taps
from analysis.compensation.low_rank import LowRankBank
from analysis.compensation.network import InputMap
from analysis.compensation.outcome import METHODS, NETWORK, Compensation, Trained
from analysis.compensation.relative_error import relative_error
from analysis.compensation.settings import Training
from analysis.compensation.training import train_networks
from analysis.focusing.design import fitted, peak_drive
from analysis.focusing.energy import EnergyForms
from analysis.focusing.field_fir import FieldFit
from analysis.focusing.fir import FirBank
from analysis.focusing.local_models import local_models
from analysis.focusing.methods import Constants, Method, PanelModel, designer
from analysis.focusing.over_temperature import (
    Aim,
    Aimed,
    aim,
    constants_at,
    covered,
    joined,
    responses,
    robust_forms,
    spaced,
    tap_design,
)
from analysis.focusing.panel import Panel
from analysis.focusing.performance import contrast, mean_response
from analysis.material import MaterialLaws
from analysis.progress import Progress

Predictor = Callable[[FirBank, Real], Real]


def compensate(
    model: PanelModel,
    panel: Panel,
    laws: MaterialLaws,
    spacing: float,
    training: Training,
    clock: Callable[[], float],
    step: float = 0.25,
    device: str = "cpu",
    report: Progress = lambda _stage, _share: None,
    method: Method = "stif",
    workers: int = 1,
    known: tuple[FirBank, EnergyForms] | None = None,
    place: int | None = None,
) -> Compensation:
    """Train on filters every `spacing` °C or where placed, judge every `step` °C of what laws and panel share.

    Parameters
    ----------
    model : PanelModel
    panel : Panel
    laws : MaterialLaws
    spacing : float
        Between training temperatures, K.
    training : Training
    clock : callable
        Present time, s.
    step : float
        Between the temperatures judged at, K.
    device : str
        Torch's name of the device to train on.
    report : callable
        Told the stage and the share done.
    method : str
        How the filters are designed that the networks and their rivals have to follow.
    workers : int
        Threads that design filters.
    known : (FirBank, EnergyForms), optional
        What `direct_filters` gives at the temperatures judged at; computed where left out.
    place : int, optional
        How many training temperatures are placed where the filters need them, instead of every `spacing`.

    Returns
    -------
    Compensation

    Raises
    ------
    ValueError
        Where the range gives fewer than four training temperatures.
    EvidenceCollapseError
        Where no network of some actuator is good enough.
    """
    low, high = covered(laws, panel.filters.operating_range)
    knots, everywhere = spaced(low, high, spacing), spaced(low, high, step)
    training.check_temperatures(place or len(knots))
    truth, forms = known or direct_filters(model, panel, laws, everywhere, method, report, workers)
    placed = None if place is None else place_temperatures(truth, forms, _band_lines(panel), place)
    knots = knots if placed is None else placed.temperature
    filters = _at_knots(truth, knots)
    if filters is None:
        filters, _ = direct_filters(model, panel, laws, knots, method, report, workers, stage="Training filters")
    trained: list[Trained] = []
    fed = InputMap.of(everywhere, everywhere if training.feed == "temperature" else _rigidity(laws, everywhere))

    def networks(bank: FirBank, temperature: Real) -> Real:
        trained.append(
            train_networks(
                bank, training, device, lambda epoch: report("Networks", (epoch + 1) / training.epochs), fed
            )
        )
        return trained[-1].networks.taps(temperature)

    predictors = dict(zip(METHODS, (networks, *rivals(panel, laws)), strict=True))
    taps, seconds = _predicted(predictors, filters, everywhere, clock)
    report("Networks", 1.0)
    left_out = [left_out_networks(filters, trained[0], training, device)]
    left_out += [left_out_taps(filters, predictors[name]) for name in METHODS[1:]]
    places = spaced(low, high, 5.0)
    at_places = [int(np.argmin(np.abs(everywhere - place))) for place in places]
    aims = _aims(model, panel, laws, everywhere[at_places], truth, truth.taps[at_places], taps[NETWORK][at_places])
    report("Leave one out", 1.0)
    low_rank = LowRankBank.of(filters)
    held = burdens(filters, low_rank, training.nodes, panel.filters.frequency)
    asked = model.space.asked(panel.target.displacement)
    heard = [replace(truth, taps=taps[name]).response(_band_lines(panel)) for name in METHODS]
    return Compensation(
        methods=METHODS,
        focusing=method,
        filters=filters,
        temperature=everywhere,
        frequency=_band_lines(panel),
        relative_error=np.array([relative_error(taps[name], truth.taps) for name in METHODS]),
        left_out=np.array([relative_error(one, filters.taps[1:-1]) for one in left_out]),
        contrast_direct=contrast(forms, truth.response(_band_lines(panel))),
        contrast=np.array([contrast(forms, one) for one in heard]),
        response=np.array([mean_response(forms, one, asked) for one in heard]),
        peak_drive=np.array([peak_drive(taps[name]) for name in METHODS]),
        seconds=seconds,
        size=4.0 * np.array([held[name][0] for name in METHODS]),
        update_cost=np.array([held[name][1] for name in METHODS]),
        trained=trained[0],
        low_rank=low_rank,
        aim_temperature=everywhere[at_places],
        direct_aim=aims[0],
        network_aim=aims[1],
        target_share=model.space.grid.target_share,
        placed=placed,
    )


def _at_knots(truth: FirBank, knots: Real) -> FirBank | None:
    """Return the filters at the `knots` (n,), °C, where all of them are at hand."""
    place = np.argmin(np.abs(truth.temperature - knots[:, None]), axis=1)
    if np.abs(truth.temperature[place] - knots).max() > 1e-9:
        return None
    return replace(truth, taps=truth.taps[place], temperature=knots)


def _predicted(
    predictors: dict[str, Predictor], filters: FirBank, temperature: Real, clock: Callable[[], float]
) -> tuple[dict[str, Real], Real]:
    """Taps (T, N, M) of every method at `temperature` (T,), and the seconds each took."""
    taps, seconds = {}, []
    for name, predictor in predictors.items():
        started = clock()
        taps[name] = predictor(filters, temperature)
        seconds.append(clock() - started)
    return taps, np.array(seconds)


def rivals(panel: Panel, laws: MaterialLaws) -> tuple[Predictor, ...]:
    """Methods that interpolate, in the order of `METHODS`."""

    def u(temperature: Real) -> Real:
        return _rigidity(laws, temperature)

    def spline(bank: FirBank, temperature: Real) -> Real:
        return cubic_spline(bank, bank.temperature, temperature)

    def rigidity_spline(bank: FirBank, temperature: Real) -> Real:
        return cubic_spline(bank, u(bank.temperature), u(temperature))

    lines, fit = panel.filters.frequency, FieldFit.of(panel.filters)

    def equal_reduced_frequency(bank: FirBank, temperature: Real) -> Real:
        wanted = reduced_frequency(bank, u(bank.temperature), u(temperature), lines)
        return fitted(wanted, temperature, fit, bank.delay).taps

    def low_rank(bank: FirBank, temperature: Real) -> Real:
        return LowRankBank.of(bank).taps(temperature)

    return linear, spline, rigidity_spline, equal_reduced_frequency, low_rank


def _rigidity(laws: MaterialLaws, temperature: Real) -> Real:
    material = laws.at(temperature)
    return log_root_rigidity(material.youngs_modulus, material.poisson_ratio)


def _band_lines(panel: Panel) -> Real:
    lines = panel.filters.frequency
    return lines[panel.filters.in_band(lines)]


def direct_filters(
    model: PanelModel,
    panel: Panel,
    laws: MaterialLaws,
    temperature: Real,
    method: Method = "stif",
    report: Progress = lambda _stage, _share: None,
    workers: int = 1,
    stage: str = "Filters everywhere",
) -> tuple[FirBank, EnergyForms]:
    """FIR filters computed at every temperature, and the energy forms of the band there.

    Parameters
    ----------
    model : PanelModel
    panel : Panel
    laws : MaterialLaws
    temperature : (T,) ndarray, °C
    method : str
        How the filters are designed.
    report : callable
        Told the stage and the share done.
    workers : int
        Threads that design filters.
    stage : str
        Name under which progress is reported.

    Returns
    -------
    FirBank
        Filters (T, N, M).
    EnergyForms
        Of the F lines of the band, at every temperature.

    Raises
    ------
    ValueError
        For a material outside the box of the model.
    """
    lines = panel.filters.frequency
    band = panel.filters.in_band(lines)
    design, error = tap_design(method, model, panel, laws), panel.filters.thermometer_error

    def known(around: Real) -> list[Constants]:
        return constants_at(laws, np.clip(around, *laws.temperature_range))

    def at(t: int) -> tuple[Real, EnergyForms]:
        local = local_to[t]
        (constants, amplitude), *_ = responses(local, laws, temperature[t : t + 1], lines)
        form = local.space.forms([amplitude], panel.target.displacement)
        wanted = robust_forms(local, panel, laws, float(temperature[t]), form)
        filters = designer(method, local, panel, lines)(constants, amplitude, wanted)
        return design.taps(wanted, filters), form.at(slice(None), band)

    taps, forms = [], []
    with ThreadPoolExecutor(workers) as pool:
        local_to = local_models(model, known, temperature, lines, error, pool)
        for done, (tap, form) in enumerate(pool.map(at, range(len(temperature))), start=1):
            taps.append(tap)
            forms.append(form)
            report(stage, done / len(temperature))
    return design.bank(np.array(taps), temperature), EnergyForms(
        np.concatenate([part.plate for part in forms]),
        np.concatenate([part.target for part in forms]),
        np.concatenate([part.aim for part in forms]),
    )


def _aims(
    model: PanelModel, panel: Panel, laws: MaterialLaws, temperature: Real, like: FirBank, *banks: Real
) -> tuple[Aim, ...]:
    """Judge the taps (A, N, M) of several banks `like` one at `temperature` (A,)."""
    lines = _band_lines(panel)
    whole = np.ones(len(lines), dtype=bool)
    asked = model.space.asked(panel.target.displacement)
    found: list[list[Aimed]] = [[] for _ in banks]
    for t, (_, amplitude) in enumerate(responses(model, laws, temperature, lines)):
        forms = model.space.forms([amplitude], panel.target.displacement)
        for rows, taps in zip(found, banks, strict=True):
            bank = replace(like, taps=taps[t : t + 1], temperature=temperature[t : t + 1])
            rows.append(aim(model.space, forms, amplitude, whole, bank.response(lines)[0], asked))
    return tuple(joined(rows) for rows in found)
