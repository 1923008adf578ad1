"""Training of a network bank; its error at temperatures left out, and over number of nodes and spacing.

Data are scaled and rotated for a batch of networks, and their initial weights drawn.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.compensation.bayesian import BayesianFit, TrainingProblem, train
from analysis.compensation.evidence_collapse import EvidenceCollapseError
from analysis.compensation.linearised import Tensor, Weights, on_device, on_processor, predict
from analysis.compensation.network import InputMap, NetworkBank, relative_error
from analysis.compensation.outcome import NetworkStudy, Trained
from analysis.compensation.settings import Training
from analysis.focusing.energy import EnergyForms
from analysis.focusing.fir import FirBank
from analysis.focusing.performance import contrast


@dataclass(frozen=True)
class Batch:
    """Scaled and rotated training data of B networks, and their first weights.

    Attributes
    ----------
    problem : TrainingProblem
    start : Weights
    axes : (B, k, M) ndarray
        Orthonormal rows: the directions of tap space that matter.
    scale, offset : (B, M) ndarray
        Taps are scale · output + offset.
    """

    problem: TrainingProblem
    start: Weights
    axes: Real
    scale: Real
    offset: Real

    def bank(self, weights: Weights, chosen: NDArray[np.int64], inputs: InputMap) -> NetworkBank:
        """Networks with rotation and scale undone, of the `chosen` members.

        Parameters
        ----------
        weights : Weights
            Of all B networks.
        chosen : (N,) ndarray of int
            Members of the batch, one per actuator.
        """
        output = on_processor(weights.output)[chosen] @ self.axes[chosen] * self.scale[chosen, None, :]
        output[:, -1] += self.offset[chosen]
        return NetworkBank(inputs, on_processor(weights.slope)[chosen], on_processor(weights.bias)[chosen], output)


def prepare(
    inputs: Real,
    targets: Real,
    used: Real,
    settings: Training,
    rng: np.random.Generator,
    device: str = "cpu",
    hidden: tuple[Real, Real] | None = None,
) -> Batch:
    """Scale and rotate targets, and draw first weights.

    Parameters
    ----------
    inputs : (n,) ndarray
        On -1..1.
    targets : (B, n, M) ndarray
        Taps, V per unit of audio signal.
    used : (B, n) ndarray
        1 for samples trained on, 0 for samples left out.
    rng : numpy Generator
        Draws the first weights.
    device : str
        To train on: ``cpu``, or torch's name of another.
    hidden : ((B, H) ndarray, (B, H) ndarray), optional
        Slope and bias of known hidden layers to start from; drawn where left out.
    """
    seen = np.where(used[:, :, None] > 0.0, targets, np.nan)
    low, high = np.nanmin(seen, axis=1), np.nanmax(seen, axis=1)
    offset, half = 0.5 * (high + low), 0.5 * (high - low)
    largest = half.max(axis=1, keepdims=True)
    # Filters of a plate whose laws do not change with temperature are equal to the last digit.
    largest = np.where(largest > 0.0, largest, 1.0)
    # A tap that is the same at all temperatures has no scale of its own: only its offset is learnt.
    own: Real = np.where(half > 1e-12 * largest, half, largest)
    scale: Real = own if settings.scale == "tap" else np.broadcast_to(largest, half.shape)
    stretched = (targets - offset[:, None]) / scale[:, None]
    slope, bias = hidden if hidden is not None else _spread_nodes(len(targets), settings.nodes, rng)
    if settings.start == "warm":
        axes = np.linalg.svd(stretched, full_matrices=False)[2]
        rotated = stretched @ axes.transpose(0, 2, 1)
        output = _ridge(inputs, rotated, used, slope, bias)
    else:
        drawn = rng.uniform(-1.0, 1.0, size=(len(targets), settings.nodes + 1, targets.shape[-1]))
        joined = np.concatenate([stretched, drawn], axis=1)
        axes = np.linalg.svd(joined, full_matrices=False)[2]
        rotated = stretched @ axes.transpose(0, 2, 1)
        output = drawn @ axes.transpose(0, 2, 1)

    fed, wanted, counted = (on_device(array, device) for array in (inputs, rotated, used))
    start = Weights(*(on_device(array, device) for array in (slope, bias, output)))
    return Batch(TrainingProblem(fed, wanted, counted, targets.shape[-1]), start, axes, scale, offset)


def outputs_at(batch: Batch, weights: Weights, inputs: Real) -> Real:
    """Taps of a batch's networks, rotation and scale undone.

    Parameters
    ----------
    inputs : (n,) ndarray
        On -1..1.

    Returns
    -------
    (B, n, M) ndarray
        V per unit of audio signal.
    """
    held = Weights(*(on_processor(part) for part in (weights.slope, weights.bias, weights.output)))
    rotated = predict(held, inputs)
    taps: Real = rotated @ batch.axes * batch.scale[:, None, :] + batch.offset[:, None, :]
    return taps


def _spread_nodes(networks: int, nodes: int, rng: np.random.Generator) -> tuple[Real, Real]:
    """Hidden layers after Nguyen and Widrow (1990): bends spread evenly over -1..1, jittered."""
    slope = 0.7 * nodes * rng.choice([-1.0, 1.0], size=(networks, nodes))
    bends = np.linspace(-1.0, 1.0, nodes) if nodes > 1 else np.zeros(1)
    bends = bends + rng.uniform(-0.5, 0.5, size=(networks, nodes)) / nodes
    return slope, -slope * bends


def _ridge(inputs: Real, targets: Real, used: Real, slope: Real, bias: Real) -> Real:
    hidden = np.tanh(inputs[:, None] * slope[:, None, :] + bias[:, None, :])
    features = np.concatenate([hidden, np.ones((*hidden.shape[:2], 1))], axis=2) * used[:, :, None]
    gram: Real = features.transpose(0, 2, 1) @ features + 1e-6 * np.eye(features.shape[2])
    weights = np.linalg.solve(gram, features.transpose(0, 2, 1) @ (targets * used[:, :, None]))
    return np.asarray(weights, dtype=np.float64)


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


def left_out_taps(filters: FirBank, method: Callable[[FirBank, Real], Real]) -> Real:
    """Taps (n-2, N, M) that a `method` (filters, temperatures) gives at each inner temperature withheld."""
    found = []
    for left in range(1, len(filters.temperature) - 1):
        keep = np.arange(len(filters.temperature)) != left
        rest = replace(filters, taps=filters.taps[keep], temperature=filters.temperature[keep])
        found.append(method(rest, filters.temperature[left : left + 1])[0])
    return np.array(found)


def left_out_networks(
    filters: FirBank, trained: Trained, settings: Training, device: str = "cpu", epochs: int = 300
) -> Real:
    """Predict every inner training filter by networks trained without it.

    All of them are trained side by side, each from the hidden layer of the full training.

    Parameters
    ----------
    filters : FirBank
        At the n training temperatures.
    trained : Trained
        The networks trained on all of them.
    device : str
        To train on: ``cpu``, or torch's name of another.
    epochs : int
        Largest number of steps tried.

    Returns
    -------
    (n - 2, N, M) ndarray
        Taps of each filter left out.
    """
    count, actuators = filters.taps.shape[:2]
    inner = np.arange(1, count - 1)
    targets = np.repeat(filters.taps.transpose(1, 0, 2)[None], len(inner), axis=0).reshape(
        -1, *filters.taps.shape[::2]
    )
    used = np.ones((len(inner), actuators, count))
    used[np.arange(len(inner)), :, inner] = 0.0
    inputs = trained.networks.input.at(filters.temperature)
    hidden = tuple(np.tile(layer, (len(inner), 1)) for layer in (trained.networks.slope, trained.networks.bias))
    batch = prepare(
        inputs,
        targets,
        used.reshape(-1, count),
        replace(settings, start="warm"),
        np.random.default_rng(settings.seed),
        device,
        (hidden[0], hidden[1]),
    )
    fit = train(batch.problem, batch.start, epochs)
    taps = outputs_at(batch, fit.weights, inputs).reshape(len(inner), actuators, count, -1)
    return np.asarray(taps[np.arange(len(inner)), :, inner])


RESTARTS = 6
"""Further trainings with other initial weights if the first one was refused."""


def study_networks(
    truth: FirBank,
    forms: EnergyForms,
    frequency: Real,
    choices: Sequence[tuple[int, float]],
    training: Training,
    inputs: InputMap,
    report: Callable[[float], None] = lambda _share: None,
) -> NetworkStudy:
    """Train with each (nodes, spacing) on filters of `truth` at that spacing; assess on all temperatures.

    Parameters
    ----------
    truth : FirBank
        Filters computed at every temperature.
    forms : EnergyForms
        At the temperatures of `truth` and the lines `frequency`.
    frequency : (F,) ndarray, Hz
        Lines of the band.
    choices : sequence of (int, float)
        Hidden nodes, and spacing of the training temperatures, K.
    training : Training
        Settings other than the nodes.
    report : callable
        Called with the share done.

    Returns
    -------
    NetworkStudy
        NaN where the evidence collapsed for every restart.
    """
    direct = contrast(forms, truth.response(frequency))
    errors, losses = [], []
    for number, (nodes, spacing) in enumerate(choices):
        knots = _every(truth.temperature, spacing)
        bank = replace(truth, taps=truth.taps[knots], temperature=truth.temperature[knots])
        try:
            taps = _trained(bank, replace(training, nodes=nodes), inputs).taps(truth.temperature)
        except EvidenceCollapseError:
            errors.append(np.full(truth.taps.shape[1], np.nan))
            losses.append(np.nan)
        else:
            errors.append(relative_error(taps, truth.taps).mean(axis=0))
            response = replace(truth, taps=taps).response(frequency)
            losses.append(float((direct - contrast(forms, response)).max()))
        report((number + 1) / len(choices))
    nodes_of, spacings = (np.array(part, dtype=float) for part in zip(*choices, strict=True))
    return NetworkStudy(nodes_of, spacings, np.array(errors), np.array(losses))


def _trained(bank: FirBank, training: Training, inputs: InputMap) -> NetworkBank:
    """Train, up to `RESTARTS` times more if the evidence collapsed: likely with more nodes than temperatures."""
    try:
        return train_networks(bank, training, inputs=inputs).networks
    except EvidenceCollapseError:
        return train_networks(bank, replace(training, restarts=RESTARTS), inputs=inputs).networks


def _every(temperature: Real, spacing: float) -> NDArray[np.intp]:
    """Rows nearest to every `spacing` °C from the first, and the last."""
    wanted = np.append(np.arange(temperature[0], temperature[-1] - 1e-9, spacing), temperature[-1])
    return np.unique(np.argmin(np.abs(temperature - wanted[:, None]), axis=1))
