"""Compensation from filters of measured transfers, without laws or twin, assessed at measured temperatures."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from analysis.arrays import Real
from analysis.compensation.network import LowRankBank, relative_error
from analysis.compensation.outcome import NETWORK, Compensation, Trained, burdens
from analysis.compensation.rivals import plain_rivals
from analysis.compensation.settings import FEWEST_TRAINING_TEMPERATURES, Training
from analysis.compensation.training import left_out_networks, left_out_taps, train_networks
from analysis.focusing.design import peak_drive
from analysis.focusing.fir import FirBank
from analysis.focusing.measured import MeasuredPanel, focus_measured
from analysis.focusing.methods import Method
from analysis.focusing.performance import Aim, Aimed, aim, joined
from analysis.focusing.sound_aim import SoundAim
from analysis.progress import Progress

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
