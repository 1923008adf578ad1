"""The compensation put to the test: every method at every quarter of a degree (paper 5.3 and 5.4)."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.compensation.burden import burdens
from analysis.compensation.direct_filters import direct_filters
from analysis.compensation.knots import PlacedTemperatures, check_places, place_temperatures
from analysis.compensation.leave_one_out import left_out_networks, left_out_taps
from analysis.compensation.low_rank import LowRankBank
from analysis.compensation.network import InputMap
from analysis.compensation.outcome import METHODS, NETWORK, Compensation, Trained
from analysis.compensation.relative_error import relative_error
from analysis.compensation.rivals import rigidity, rivals
from analysis.compensation.settings import Training
from analysis.focusing.aim import Aim, Aimed, aim, joined
from analysis.focusing.design import peak_drive
from analysis.focusing.energy import EnergyForms
from analysis.focusing.fir import FirBank
from analysis.focusing.methods import Method
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import PanelModel
from analysis.focusing.performance import contrast, mean_response
from analysis.focusing.responses import responses
from analysis.focusing.temperatures import covered, spaced
from analysis.material import MaterialLaws
from analysis.progress import Progress

AIM_SPACING = 5.0
"""Between the temperatures at which spot errors are kept, K."""


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
        To train on: ``cpu``, or torch's name of another.
    report : callable
        Told the stage and the share done.
    method : str
        How the filters are designed that the networks and their rivals have to follow.
    workers : int
        Threads that design filters, and leave temperatures out while others judge.
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
        Where the range gives fewer than four training temperatures, or has no room for those to be placed.
    EvidenceCollapseError
        Where no network of some actuator is good enough.
    """
    from analysis.compensation.training import train_networks

    low, high = covered(laws, panel.filters.operating_range)
    knots, everywhere = spaced(low, high, spacing), spaced(low, high, step)
    if place is None:
        training.check_temperatures(len(knots))
    else:
        check_places(place, low, high)
    truth = _Truth(
        model, panel, laws, *(known or direct_filters(model, panel, laws, everywhere, method, report, workers))
    )
    placed = None if place is None else place_temperatures(truth.bank, truth.forms, truth.lines, place)
    knots = knots if placed is None else placed.temperature
    filters = truth.at_knots(knots)
    if filters is None:
        filters, _ = direct_filters(model, panel, laws, knots, method, report, workers, stage="Training filters")
    fed = InputMap.of(everywhere, everywhere if training.feed == "temperature" else rigidity(laws, everywhere))
    started = clock()
    trained = train_networks(
        filters, training, device, lambda epoch: report("Networks", (epoch + 1) / training.epochs), fed
    )
    taps, seconds = {NETWORK: trained.networks.taps(everywhere)}, {NETWORK: clock() - started}
    report("Networks", 1.0)
    others = rivals(panel, laws)
    for name, rival in others.items():
        started = clock()
        taps[name] = rival(filters, everywhere)
        seconds[name] = clock() - started
    with ThreadPoolExecutor(max(1, workers - 1)) as pool:  # after all that is timed
        left_out = {NETWORK: pool.submit(left_out_networks, filters, trained, training, device)}
        left_out |= {name: pool.submit(left_out_taps, filters, rival) for name, rival in others.items()}
        found = truth.outcome(method, filters, trained, taps, left_out, seconds, placed)
    report("Leave one out", 1.0)
    return found


@dataclass(frozen=True)
class _Truth:
    """Filters computed at every temperature, with what others are judged by there."""

    model: PanelModel
    panel: Panel
    laws: MaterialLaws
    bank: FirBank
    forms: EnergyForms

    @property
    def lines(self) -> Real:
        """Lines of the band (F,), Hz."""
        lines = self.panel.filters.frequency
        return lines[self.panel.filters.in_band(lines)]

    def at_knots(self, knots: Real) -> FirBank | None:
        """Return the filters at the `knots` (n,), °C, where all of them are at hand."""
        everywhere = self.bank.temperature
        place = np.argmin(np.abs(everywhere - knots[:, None]), axis=1)
        if np.abs(everywhere[place] - knots).max() > 1e-9:
            return None
        return replace(self.bank, taps=self.bank.taps[place], temperature=knots)

    def heard(self, taps: Real) -> Complex:
        """Responses (T, F, N) of the band to `taps` (T, N, M)."""
        return replace(self.bank, taps=taps).response(self.lines)

    def outcome(
        self,
        method: Method,
        filters: FirBank,
        trained: Trained,
        taps: dict[str, Real],
        left_out: dict[str, Future[Real]],
        seconds: dict[str, float],
        placed: PlacedTemperatures | None,
    ) -> Compensation:
        """Judge the taps (T, N, M) of every method, beside those (n-2, N, M) at temperatures left out."""
        everywhere, low_rank = self.bank.temperature, LowRankBank.of(filters)
        wanted = spaced(everywhere[0], everywhere[-1], AIM_SPACING)
        places = np.argmin(np.abs(everywhere - wanted[:, None]), axis=1)
        direct_aim, network_aim = self.aims(places, self.bank.taps, taps[NETWORK])
        held = burdens(filters, low_rank, trained.settings.nodes, self.panel.filters.frequency)
        asked = self.model.space.asked(self.panel.target.displacement)
        heard = [self.heard(taps[name]) for name in METHODS]
        return Compensation(
            methods=METHODS,
            focusing=method,
            filters=filters,
            temperature=everywhere,
            frequency=self.lines,
            relative_error=np.array([relative_error(taps[name], self.bank.taps) for name in METHODS]),
            contrast_direct=contrast(self.forms, self.heard(self.bank.taps)),
            contrast=np.array([contrast(self.forms, one) for one in heard]),
            response=np.array([mean_response(self.forms, one, asked) for one in heard]),
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
            # Last, since others compute it in the meantime.
            left_out=np.array([relative_error(left_out[name].result(), filters.taps[1:-1]) for name in METHODS]),
        )

    def aims(self, places: NDArray[np.intp], *banks: Real) -> list[Aim]:
        """Judge the taps (T, N, M) of several banks at a few of the T temperatures, those of the rows `places`."""
        temperature, lines = self.bank.temperature[places], self.lines
        whole = np.ones(len(lines), dtype=bool)
        asked = self.model.space.asked(self.panel.target.displacement)
        heard = [replace(self.bank, taps=taps[places], temperature=temperature).response(lines) for taps in banks]
        found: list[list[Aimed]] = [[] for _ in banks]
        for t, (_, amplitude) in enumerate(responses(self.model, self.laws, temperature, lines)):
            forms = self.forms.at(places[t : t + 1])
            for rows, one in zip(found, heard, strict=True):
                rows.append(aim(self.model.space, forms, amplitude, whole, one[t], asked))
        return [joined(rows) for rows in found]
