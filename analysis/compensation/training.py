"""Training of a network bank from filters at a few temperatures; the best restart is kept or refused."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.compensation.batch import outputs_at, prepare
from analysis.compensation.bayesian import BayesianFit, train
from analysis.compensation.evidence_collapse import EvidenceCollapseError
from analysis.compensation.network import InputMap, NetworkBank
from analysis.compensation.outcome import Trained
from analysis.compensation.relative_error import relative_error
from analysis.compensation.settings import Training
from analysis.compensation.tensors import Tensor, on_processor
from analysis.focusing.fir import FirBank


def train_networks(
    filters: FirBank,
    settings: Training,
    device: str = "cpu",
    progress: Callable[[int], None] | None = None,
    inputs: InputMap | None = None,
) -> Trained:
    """Train one network per actuator on the filters at a few temperatures.

    Parameters
    ----------
    filters : FirBank
        At the training temperatures.
    device : str
        To train on: ``cpu``, or torch's name of another.
    progress : callable, optional
        Called with the number of every step done, from 0.
    inputs : InputMap, optional
        Input of the networks; the temperature itself by default.

    Raises
    ------
    ValueError
        For fewer than four training temperatures.
    EvidenceCollapseError
        Where every restart of an actuator misses its own training filters by more than
        `settings.largest_error`.
    """
    settings.check_temperatures(len(filters.temperature))
    rng = np.random.default_rng(settings.seed)
    targets = np.repeat(filters.taps.transpose(1, 0, 2), settings.restarts, axis=0)
    used = split(len(targets), len(filters.temperature), settings.split, rng)
    fed = inputs or InputMap.of(filters.temperature[[0, -1]], filters.temperature[[0, -1]])
    batch = prepare(fed.at(filters.temperature), targets, used, settings, rng, device)
    fit = train(batch.problem, batch.start, settings.epochs, progress=progress)
    error = relative_error(outputs_at(batch, fit.weights, fed.at(filters.temperature)), targets)
    worst = np.where(used > 0.0, error, 0.0).max(axis=1)
    chosen = _best(fit, worst, settings, filters.taps.shape[1])
    return _report(fit, batch.bank(fit.weights, chosen, fed), chosen, worst, used, settings)


def split(networks: int, temperatures: int, kind: str, rng: np.random.Generator) -> Real:
    """Temperatures that each network trains on: all, or 85 % drawn for each as in MATLAB.

    Parameters
    ----------
    networks : int
        Number B.
    temperatures : int
        Number n.
    kind : str
        ``matlab``, or any other for all temperatures.
    rng : numpy Generator

    Returns
    -------
    (B, n) ndarray
        1 for temperatures trained on, 0 for those left out.
    """
    used = np.ones((networks, temperatures))
    if kind == "matlab":
        left_out = round(0.15 * temperatures)
        for row in used:
            row[rng.permutation(temperatures)[:left_out]] = 0.0
    return used


def _best(fit: BayesianFit, worst: Real, settings: Training, actuators: int) -> NDArray[np.int64]:
    evidence = on_processor(fit.evidence.log_evidence).reshape(actuators, settings.restarts)
    error = worst.reshape(actuators, settings.restarts)
    good = (error <= settings.largest_error) & np.isfinite(evidence)
    lost = np.flatnonzero(~good.any(axis=1))
    if lost.size:
        raise EvidenceCollapseError(
            f"actuator {lost[0] + 1}: the best of {settings.restarts} trainings misses its own training filters "
            f"by {np.nanmin(error[lost[0]]):.3g} %, more than the {settings.largest_error:g} % allowed: the "
            "evidence collapsed; try more restarts, other nodes or a smaller spacing"
        )
    kept = np.argmax(np.where(good, evidence, -np.inf), axis=1)
    chosen: NDArray[np.int64] = np.arange(actuators) * settings.restarts + kept
    return chosen


def _report(
    fit: BayesianFit, bank: NetworkBank, chosen: NDArray[np.int64], worst: Real, used: Real, settings: Training
) -> Trained:
    def kept(values: Tensor) -> Real:
        return np.asarray(on_processor(values)[chosen])

    evidence = fit.evidence
    return Trained(
        networks=bank,
        settings=settings,
        training_error=worst[chosen],
        gamma=kept(evidence.gamma),
        alpha=kept(evidence.alpha),
        beta=kept(evidence.beta),
        log_evidence=kept(evidence.log_evidence),
        epochs=kept(fit.epochs),
        restart=(chosen % settings.restarts).astype(float),
        used=used[chosen],
    )
