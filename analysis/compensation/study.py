"""Comparison of all compensation methods over a fine grid of temperatures (paper 5.3 and 5.4).

Of measured transfers, which have neither laws nor twin, the methods are assessed at the measured temperatures.
"""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.compensation.knots import PlacedTemperatures, check_places, place_temperatures
from analysis.compensation.law_band import ContrastBand, law_band
from analysis.compensation.network import InputMap, LowRankBank, relative_error
from analysis.compensation.outcome import METHODS, NETWORK, Compensation, Trained, burdens
from analysis.compensation.rivals import DirectFilters, direct_filters, plain_rivals, rigidity, rivals
from analysis.compensation.settings import FEWEST_TRAINING_TEMPERATURES, Training
from analysis.compensation.training import left_out_networks, left_out_taps, train_networks
from analysis.focusing.design import peak_drive
from analysis.focusing.fir import FirBank
from analysis.focusing.measured import MeasuredPanel, focus_measured
from analysis.focusing.methods import Method
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import PanelModel, constants_at, covered, spaced
from analysis.focusing.performance import Aim, Aimed, aim, contrast, joined, mean_response
from analysis.focusing.sound_aim import SoundAim
from analysis.material import MaterialLaws
from analysis.progress import Progress

AIM_SPACING = 5.0
"""Spacing of the temperatures at which spot errors are computed, K."""
BAND_SPACING = 10.0
"""Spacing of the temperatures at which the uncertainty of the laws is propagated, K."""


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
    known: DirectFilters | None = None,
    place: int | None = None,
) -> Compensation:
    """Train on filters every `spacing` °C or at placed temperatures; assess every `step` °C.

    Parameters
    ----------
    spacing : float
        Between training temperatures, K.
    clock : callable
        Present time, s. Other threads compute while methods are timed: on the processor, use the processor time of
        the calling thread, `time.thread_time`.
    step : float
        Spacing of the temperatures of the assessment, K; they cover the common range of laws and panel.
    device : str
        To train on: ``cpu``, or torch's name of another.
    report : callable
        Called with the stage and the share done.
    method : str
        Design method of the filters that networks and other methods have to predict.
    workers : int
        Threads that design filters and compute leave-one-out errors.
    known : DirectFilters, optional
        Result of `direct_filters` at the temperatures of the assessment; computed if not given.
    place : int, optional
        Number of training temperatures, placed by `place_temperatures` instead of every `spacing`.

    Raises
    ------
    ValueError
        Where the range has fewer than four training temperatures, or is too narrow for those to be placed.
    EvidenceCollapseError
        Where no network of some actuator is good enough.
    """
    low, high = covered(laws, panel.filters.operating_range)
    knots, everywhere = spaced(low, high, spacing), spaced(low, high, step)
    if place is None:
        training.check_temperatures(len(knots))
    else:
        check_places(place, low, high)
    direct = known or direct_filters(model, panel, laws, everywhere, method, report, workers)
    truth = _Truth(model, panel, laws, direct)
    placed = None if place is None else place_temperatures(direct.bank, direct.forms, truth.lines, place)
    knots = knots if placed is None else placed.temperature
    filters = truth.at_knots(knots)
    if filters is None:
        filters = direct_filters(model, panel, laws, knots, method, report, workers, stage="Training filters").bank
    inputs = InputMap.of(everywhere, everywhere if training.feed == "temperature" else rigidity(laws, everywhere))
    started = clock()
    trained = train_networks(
        filters, training, device, lambda epoch: report("Networks", (epoch + 1) / training.epochs), inputs
    )
    taps, seconds = {NETWORK: trained.networks.taps(everywhere)}, {NETWORK: clock() - started}
    report("Networks", 1.0)
    with ThreadPoolExecutor(workers) as pool:
        left_out = {NETWORK: pool.submit(left_out_networks, filters, trained, training, device)}
        band = pool.submit(truth.law_band, taps[NETWORK], training.seed)
        for name, rival in rivals(panel, laws).items():
            started = clock()
            taps[name] = rival(filters, everywhere)
            seconds[name] = clock() - started
            left_out[name] = pool.submit(left_out_taps, filters, rival)
        found = truth.outcome(method, filters, trained, taps, (left_out, band), seconds, placed)
    report("Leave one out", 1.0)
    return found


@dataclass(frozen=True)
class _Truth:
    """Filters computed directly at every temperature, and the means to assess others there."""

    model: PanelModel
    panel: Panel
    laws: MaterialLaws
    direct: DirectFilters

    @property
    def lines(self) -> Real:
        """Lines of the band (F,), Hz."""
        lines = self.panel.filters.frequency
        return lines[self.panel.filters.in_band(lines)]

    def at_knots(self, knots: Real) -> FirBank | None:
        """Return the filters at the `knots` (n,), °C, or None if one of them is missing."""
        bank, places = self.direct.bank, self.places(knots)
        if np.abs(bank.temperature[places] - knots).max() > 1e-9:
            return None
        return replace(bank, taps=bank.taps[places], temperature=knots)

    def places(self, wanted: Real) -> NDArray[np.intp]:
        """Rows (n,) of the temperatures nearest to those `wanted` (n,), °C."""
        nearest: NDArray[np.intp] = np.argmin(np.abs(self.direct.bank.temperature - wanted[:, None]), axis=1)
        return nearest

    def response(self, taps: Real) -> Complex:
        """Responses (T, F, N) of the band to `taps` (T, N, M)."""
        return replace(self.direct.bank, taps=taps).response(self.lines)

    def law_band(self, taps: Real, seed: int) -> ContrastBand:
        """Contrast of `taps` (T, N, M) under the uncertainty of the laws; `seed` of the random draws."""
        everywhere = self.direct.bank.temperature
        places = self.places(spaced(everywhere[0], everywhere[-1], BAND_SPACING))
        bank = replace(self.direct.bank, taps=taps[places], temperature=everywhere[places])
        models = [self.direct.models[place] for place in places]
        return law_band(models, self.panel, self.laws, bank, np.random.default_rng(seed))

    def outcome(
        self,
        method: Method,
        filters: FirBank,
        trained: Trained,
        taps: dict[str, Real],
        awaited: tuple[dict[str, Future[Real]], Future[ContrastBand]],
        seconds: dict[str, float],
        placed: PlacedTemperatures | None,
    ) -> Compensation:
        """Assess the taps (T, N, M) of every method; leave-one-out taps (n-2, N, M) and the band are `awaited`."""
        (left_out, band), bank, forms = awaited, self.direct.bank, self.direct.forms
        everywhere, low_rank = bank.temperature, LowRankBank.of(filters)
        places = self.places(spaced(everywhere[0], everywhere[-1], AIM_SPACING))
        direct_aim, network_aim = self.aims(places, bank.taps, taps[NETWORK])
        held = burdens(filters, low_rank, trained.settings.nodes, self.panel.filters.frequency)
        asked = self.model.space.asked(self.panel.target.displacement)
        responses = [self.response(taps[name]) for name in METHODS]
        return Compensation(
            methods=METHODS,
            focusing=method,
            filters=filters,
            temperature=everywhere,
            frequency=self.lines,
            relative_error=np.array([relative_error(taps[name], bank.taps) for name in METHODS]),
            contrast_direct=contrast(forms, self.response(bank.taps)),
            contrast=np.array([contrast(forms, one) for one in responses]),
            response=np.array([mean_response(forms, one, asked) for one in responses]),
            peak_drive=np.array([peak_drive(taps[name]) for name in METHODS]),
            seconds=np.array([seconds[name] for name in METHODS]),
            size=4.0 * np.array([held[name][0] for name in METHODS]),
            update_cost=np.array([held[name][1] for name in METHODS]),
            trained=trained,
            low_rank=low_rank,
            aim_temperature=everywhere[places],
            direct_aim=direct_aim,
            network_aim=network_aim,
            target_share=self.model.space.grid.target_share,
            placed=placed,
            # Last, because other threads compute it in the meantime.
            left_out=np.array([relative_error(left_out[name].result(), filters.taps[1:-1]) for name in METHODS]),
            law_band=band.result(),
        )

    def aims(self, places: NDArray[np.intp], *banks: Real) -> list[Aim]:
        """Contrast and spot error of several banks' taps (T, N, M) at the temperatures of the rows `places`."""
        temperature, lines = self.direct.bank.temperature[places], self.lines
        asked = self.model.space.asked(self.panel.target.displacement)
        responses = [
            replace(self.direct.bank, taps=taps[places], temperature=temperature).response(lines) for taps in banks
        ]
        found: list[list[Aimed]] = [[] for _ in banks]
        sound = SoundAim.judging(self.panel, self.model.space.grid)
        for t, constants in enumerate(constants_at(self.laws, temperature)):
            model, forms = self.direct.models[places[t]], self.direct.forms.at(places[t : t + 1])
            amplitude = model.amplitudes(*constants, lines)
            for rows, one in zip(found, responses, strict=True):
                rows.append(aim(model.space, forms, amplitude, one[t], asked, sound))
        return [joined(rows) for rows in found]


DIRECT = "direct"
"""Name of the filters designed directly from the transfers at a temperature."""


def compensate_measured(
    measured: MeasuredPanel,
    training: Training,
    clock: Callable[[], float],
    device: str = "cpu",
    report: Progress = lambda _stage, _share: None,
    method: Method = "stif",
    workers: int = 1,
) -> Compensation:
    """Train on the filters of all measured temperatures; assess by leaving out each inner temperature.

    Between the measured temperatures there is no reference. So a method trained on the other temperatures is
    assessed at the one left out, with the transfers measured there. The temperature step is then twice as wide as
    in use, so that the errors are larger than in use.

    Parameters
    ----------
    measured : MeasuredPanel
        At n temperatures.
    training : Training
        Its `feed` is ignored: the input is the temperature, because log √D is not known.
    clock : callable
        Present time, s.
    device : str
        To train on: ``cpu``, or torch's name of another.
    report : callable
        Called with the stage and the share done.
    method : str
        Design method of the training filters.
    workers : int
        Threads that design filters.

    Returns
    -------
    Compensation
        Assessed at the n - 2 inner temperatures.

    Raises
    ------
    ValueError
        For fewer than five temperatures, and for modal control, which needs a model's modes.
    EvidenceCollapseError
        Where no network of some actuator is good enough.
    """
    temperature = measured.transfers.temperature
    if len(temperature) < FEWEST_TRAINING_TEMPERATURES + 1:
        raise ValueError(
            f"transfers at {len(temperature)} temperatures; at least {FEWEST_TRAINING_TEMPERATURES + 1} are "
            "needed, to train on all but one: measure more"
        )
    training = replace(training, feed="temperature")
    filters = focus_measured(measured, method, report, workers).bank
    started = clock()
    trained = train_networks(
        filters, training, device, lambda epoch: report("Networks", (epoch + 1) / training.epochs)
    )
    taps, seconds = {NETWORK: left_out_networks(filters, trained, training, device)}, [clock() - started]
    for name, rival in plain_rivals().items():
        started = clock()
        taps[name] = left_out_taps(filters, rival)
        seconds.append(clock() - started)
    report("Leave one out", 1.0)
    return _outcome(measured, filters, trained, taps, method, np.array(seconds))


def _outcome(
    measured: MeasuredPanel,
    filters: FirBank,
    trained: Trained,
    taps: dict[str, Real],
    method: Method,
    seconds: Real,
) -> Compensation:
    """Assess the `taps` (n-2, N, M) that every method predicts for the temperatures left out."""
    inner, direct = filters.temperature[1:-1], filters.taps[1:-1]
    aims = _aims(measured, replace(filters, taps=direct, temperature=inner), {DIRECT: direct} | taps)
    low_rank = LowRankBank.of(filters)
    lines = measured.panel.filters.frequency
    held = burdens(filters, low_rank, trained.settings.nodes, lines)
    errors = np.array([relative_error(one, direct) for one in taps.values()])
    return Compensation(
        methods=tuple(taps),
        focusing=method,
        filters=filters,
        temperature=inner,
        frequency=lines[measured.panel.filters.in_band(lines)],
        relative_error=errors,
        left_out=errors,
        contrast_direct=aims[DIRECT].contrast,
        contrast=np.array([aims[name].contrast for name in taps]),
        response=np.array([aims[name].response for name in taps]),
        peak_drive=np.array([peak_drive(one) for one in taps.values()]),
        seconds=seconds,
        size=4.0 * np.array([held[name][0] for name in taps]),
        update_cost=np.array([held[name][1] for name in taps]),
        trained=trained,
        low_rank=low_rank,
        aim_temperature=inner,
        direct_aim=aims[DIRECT],
        network_aim=aims[NETWORK],
        target_share=measured.space.grid.target_share,
        judged="left-out",
    )


def _aims(measured: MeasuredPanel, like: FirBank, banks: dict[str, Real]) -> dict[str, Aim]:
    """Contrast and spot error of every bank's taps (n-2, N, M), with the transfers of the inner temperatures."""
    settings, displacement = measured.panel.filters, measured.panel.target.displacement
    band = settings.in_band(settings.frequency)
    asked = measured.space.asked(displacement)
    response = {name: replace(like, taps=taps).response(settings.frequency[band]) for name, taps in banks.items()}
    found: dict[str, list[Aimed]] = {name: [] for name in banks}
    sound = SoundAim.judging(measured.panel, measured.grid)
    for t in range(len(like.temperature)):
        amplitude, (_, judged) = measured.amplitudes(t + 1)[:, band], measured.forms(t + 1, displacement)
        judged = judged.at(slice(None), band)
        for name, rows in found.items():
            rows.append(aim(measured.space, judged, amplitude, response[name][t], asked, sound))
    return {name: joined(rows) for name, rows in found.items()}
