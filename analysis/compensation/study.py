"""The compensation put to the test: every method at every quarter of a degree (paper 5.3 and 5.4)."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Real
from analysis.compensation.interpolation import cubic_spline, linear, log_root_rigidity, reduced_frequency
from analysis.compensation.leave_one_out import leave_one_out, leave_one_out_networks
from analysis.compensation.network import InputMap
from analysis.compensation.relative_error import relative_error
from analysis.compensation.settings import Training
from analysis.compensation.training import Trained, train_networks
from analysis.focusing.energy import EnergyForms
from analysis.focusing.fir import FirBank, design
from analysis.focusing.inversion import invert
from analysis.focusing.methods import PanelModel
from analysis.focusing.over_temperature import Aim, aim, covered, responses, spaced
from analysis.focusing.panel import Panel
from analysis.focusing.performance import contrast
from analysis.material import MaterialLaws
from analysis.progress import Progress

Predictor = Callable[[FirBank, Real], Real]

NETWORK, LINEAR, SPLINE, RIGIDITY_SPLINE, REDUCED_FREQUENCY = METHODS = (
    "network",
    "linear",
    "cubic-spline",
    "cubic-spline-rigidity",
    "reduced-frequency",
)


@dataclass(frozen=True)
class Compensation:
    """What every method makes of the filters at a few temperatures; m methods, N actuators.

    Attributes
    ----------
    methods : tuple of str
    training_temperature : (n,) ndarray
        Degrees Celsius.
    temperature : (T,) ndarray
        Where all is judged, degrees Celsius.
    frequency : (F,) ndarray
        Lines of the band, Hz.
    relative_error : (m, T, N) ndarray
        Paper eq. (13), %.
    left_out : (m, n-2, N) ndarray
        Relative error at inner training temperatures left out, %: known without the filters in between.
    contrast_direct : (T, F) ndarray
        With the FIR filters computed at that temperature.
    contrast : (m, T, F) ndarray
        With those of each method.
    seconds : (m,) ndarray
        Training or fitting, and all T evaluations.
    trained : Trained
        The networks.
    aim_temperature : (A,) ndarray
        Degrees Celsius.
    direct_aim, network_aim : Aim
        Contrast and spot error there (A, F), with filters computed directly and by the networks.
    """

    methods: tuple[str, ...]
    training_temperature: Real
    temperature: Real
    frequency: Real
    relative_error: Real
    left_out: Real
    contrast_direct: Real
    contrast: Real
    seconds: Real
    trained: Trained
    aim_temperature: Real
    direct_aim: Aim
    network_aim: Aim

    @property
    def contrast_loss(self) -> Real:
        """Contrast (m, T, F) lost against the filters computed directly."""
        return self.contrast_direct - self.contrast

    @property
    def best(self) -> str:
        """Method of the smallest largest relative error."""
        return self.methods[int(np.argmin(self.relative_error.max(axis=(1, 2))))]


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
) -> Compensation:
    """Train on filters every `spacing` °C, judge every `step` °C of the range laws and panel share.

    Raises
    ------
    ValueError
        Where the range gives too few training temperatures for the nodes.
    EvidenceCollapseError
        Where no network of some actuator is good enough.
    """
    low, high = covered(laws, panel.filters.operating_range)
    knots, everywhere = spaced(low, high, spacing), spaced(low, high, step)
    training.check_temperatures(len(knots))
    truth, forms = _direct(model, panel, laws, everywhere, report)
    filters, _ = _direct(model, panel, laws, knots, report, stage="Training filters")
    trained: list[Trained] = []
    fed = InputMap.of(everywhere, everywhere if training.feed == "temperature" else _rigidity(laws, everywhere))

    def networks(bank: FirBank, temperature: Real) -> Real:
        trained.append(
            train_networks(
                bank, training, device, lambda epoch: report("Networks", (epoch + 1) / training.epochs), fed
            )
        )
        return trained[-1].networks.taps(temperature)

    predictors = dict(zip(METHODS, (networks, *rivals(model, panel, laws, knots)), strict=True))
    taps, seconds = _predicted(predictors, filters, everywhere, clock)
    report("Networks", 1.0)
    left_out = [leave_one_out_networks(filters, trained[0], training, device)]
    left_out += [leave_one_out(filters, predictors[name]) for name in METHODS[1:]]
    places = spaced(low, high, 5.0)
    at_places = [int(np.argmin(np.abs(everywhere - place))) for place in places]
    aims = _aims(model, panel, laws, everywhere[at_places], truth.taps[at_places], taps[NETWORK][at_places])
    report("Leave one out", 1.0)
    return Compensation(
        methods=METHODS,
        training_temperature=knots,
        temperature=everywhere,
        frequency=_band_lines(panel),
        relative_error=np.array([relative_error(taps[name], truth.taps) for name in METHODS]),
        left_out=np.array(left_out),
        contrast_direct=_contrast(forms, panel, everywhere, truth.taps),
        contrast=np.array([_contrast(forms, panel, everywhere, taps[name]) for name in METHODS]),
        seconds=seconds,
        trained=trained[0],
        aim_temperature=everywhere[at_places],
        direct_aim=aims[0],
        network_aim=aims[1],
    )


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


def rivals(model: PanelModel, panel: Panel, laws: MaterialLaws, knots: Real) -> tuple[Predictor, ...]:
    """Methods that interpolate, in the order of `METHODS`, given the training temperatures `knots`."""

    def u(temperature: Real) -> Real:
        return _rigidity(laws, temperature)

    def spline(bank: FirBank, temperature: Real) -> Real:
        return cubic_spline(bank, bank.temperature, temperature)

    def rigidity_spline(bank: FirBank, temperature: Real) -> Real:
        return cubic_spline(bank, u(bank.temperature), u(temperature))

    lines = _wide_lines(panel)
    settings = panel.filters
    amplitudes = (amplitude for _, amplitude in responses(model, laws, knots, lines))
    wide = invert(
        model.space.forms(amplitudes, panel.target.displacement), settings.tolerance, settings.regularisation
    ).filters

    def equal_reduced_frequency(bank: FirBank, temperature: Real) -> Real:
        known = np.searchsorted(knots, bank.temperature - 1e-9)
        complex_filters = reduced_frequency(
            wide[known], lines, u(bank.temperature), u(temperature), settings.frequency
        )
        return design(complex_filters, temperature, settings).taps

    return linear, spline, rigidity_spline, equal_reduced_frequency


def _rigidity(laws: MaterialLaws, temperature: Real) -> Real:
    material = laws.at(temperature)
    return log_root_rigidity(material.youngs_modulus, material.poisson_ratio)


def _wide_lines(panel: Panel) -> Real:
    """Lines of the settings and beyond, as far as the panel's twin is asked to reach."""
    lines = panel.filters.frequency
    spacing = lines[1] - lines[0]
    low, high = panel.filters.twin_band
    below = np.arange(lines[0] - spacing, low, -spacing)[::-1]
    return np.concatenate([below, lines, np.arange(lines[-1] + spacing, high, spacing)])


def _band_lines(panel: Panel) -> Real:
    lines = panel.filters.frequency
    return lines[panel.filters.in_band(lines)]


def _direct(
    model: PanelModel,
    panel: Panel,
    laws: MaterialLaws,
    temperature: Real,
    report: Progress,
    stage: str = "Filters everywhere",
) -> tuple[FirBank, EnergyForms]:
    """FIR filters computed at every temperature, and the energy forms of the band there."""
    settings = panel.filters
    lines = settings.frequency
    band = settings.in_band(lines)

    def at(t: int) -> tuple[Real, EnergyForms]:
        here = temperature[t : t + 1]
        (_, amplitude), *_ = responses(model, laws, here, lines)
        form = model.space.forms([amplitude], panel.target.displacement)
        filters = invert(form, settings.tolerance, settings.regularisation).filters
        return design(filters, here, settings).taps, form.at(slice(None), band)

    taps, forms = [], []
    with ThreadPoolExecutor(2) as pool:
        for done, (tap, form) in enumerate(pool.map(at, range(len(temperature))), start=1):
            taps.append(tap)
            forms.append(form)
            report(stage, done / len(temperature))
    bank = FirBank(np.concatenate(taps), temperature, settings.sample_rate, settings.delay)
    return bank, EnergyForms(
        np.concatenate([part.plate for part in forms]),
        np.concatenate([part.target for part in forms]),
        np.concatenate([part.aim for part in forms]),
    )


def _contrast(forms: EnergyForms, panel: Panel, temperature: Real, taps: Real) -> Real:
    bank = FirBank(taps, temperature, panel.filters.sample_rate, panel.filters.delay)
    return contrast(forms, bank.response(_band_lines(panel)))


def _aims(model: PanelModel, panel: Panel, laws: MaterialLaws, temperature: Real, *banks: Real) -> tuple[Aim, ...]:
    """Judge the taps (A, N, M) of several banks at `temperature` (A,)."""
    lines = _band_lines(panel)
    whole = np.ones(len(lines), dtype=bool)
    settings = panel.filters
    found: list[list[tuple[Real, Real]]] = [[] for _ in banks]
    for t, (_, amplitude) in enumerate(responses(model, laws, temperature, lines)):
        forms = model.space.forms([amplitude])
        for rows, taps in zip(found, banks, strict=True):
            bank = FirBank(taps[t : t + 1], temperature[t : t + 1], settings.sample_rate, settings.delay)
            rows.append(aim(model.space, forms, amplitude, whole, bank.response(lines)[0]))
    return tuple(Aim(np.array([r[0] for r in rows]), np.array([r[1] for r in rows])) for rows in found)
