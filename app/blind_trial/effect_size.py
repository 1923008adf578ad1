"""Size of a hidden effect in a campaign, in sigma, from the FRFs that are predicted for it.

Sigma is that of the gap workflow: noise together with the error of the twin that judges, estimated for this plate
and common to all lines. What declared quantities can do as well within their tolerances is no part of a size,
because nobody could tell it from them.
"""

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from analysis.arrays import Complex
from analysis.effect_card import Values
from analysis.gap.data.noise import carried_error
from analysis.gap.data.preparation import prepare
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.fitting.normal_equations import WhitenedSweep, linearise_all, whiten_all
from analysis.gap.fitting.schur_complement import schur_complement
from analysis.gap.fitting.state import FreeParameters, GapState, starting_state
from analysis.gap.imperfect.discrepancy import Discrepancy, DiscrepancyShape
from analysis.gap.search.score_test import score_test
from analysis.material import MaterialSigma
from analysis.protocol.sweep import drive_signal
from analysis.recordings.frf import Frf
from analysis.recordings.mains import mains_lines
from analysis.recordings.sweep_point import SweepPoint
from analysis.updated import Updated
from app.blind_trial.specimen import Specimen
from simulation.effects.library import LIBRARY
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

MAINS = 50.0
"""Hz."""
QUIETER_NOISE_FACTOR = 100.0
"""Factor by which the noise is lower where scatter is computed: the signals have none, and some are below it."""


@dataclass(frozen=True)
class EffectSize:
    """A simulated campaign of the specimen without effects, linearised there.

    Attributes
    ----------
    specimen : Specimen
    sweeps : GapSweeps
    state : GapState
        True laws and gain.
    noise : float
        V rms on every input.
    executor : Executor
    declared : FreeParameters
        Quantities that are declared with a tolerance.
    columns : list of WhitenedSweep
        Derivatives by laws, temperatures, gains and them, of the twin that judges, for weights of 1.
    """

    specimen: Specimen
    sweeps: GapSweeps
    state: GapState
    noise: float
    executor: Executor
    declared: FreeParameters
    columns: list[WhitenedSweep]

    @classmethod
    def of(
        cls,
        specimen: Specimen,
        judging: Twin[EffectPlate],
        share: float,
        rng: np.random.Generator,
        executor: Executor,
    ) -> "EffectSize":
        """Choose the noise by its share of the response in the FRF of a mean sweep.

        Parameters
        ----------
        specimen : Specimen
        judging : Twin
            That judges the campaign.
        share : float
            0.01 is 1 % of the response on a line.
        rng : numpy.random.Generator
            Of the noise.
        executor : Executor
            Sweeps are computed on it.

        Returns
        -------
        EffectSize
        """
        frf, noise = expected_frf(specimen, share, rng)
        updated = true_updating(specimen, frf)
        sweeps = prepare(frf, specimen.declared.protocol, updated)[0]
        error = judging.plate.operators.numerical_error(float(updated.material.loss_factor.min()))
        sweeps = replace(sweeps, twin_error=carried_error(error))
        state, cards = starting_state(updated, sweeps.groups), judging.tolerance_cards
        known = replace(FreeParameters.of({}, (), cards), trusted=sweeps.overstated)
        there = state.with_tolerances(cards)
        tangents = [(name, parameter, there.declared[name]) for name, parameter in known.names]
        columns = whiten_all(judging, sweeps, there, tangents, executor)
        return cls(specimen, sweeps, state, noise, executor, known, columns)

    @property
    def sigma(self) -> float:
        """Standard deviation of noise and the twin's own error along one effect, in sigma of the noise."""
        return float(np.sqrt(self.sweeps.overstated))

    def signal(self, effects: Mapping[str, Values]) -> Complex:
        """Return the change of the recorded FRFs by `effects`, as spline coefficients (T, K, n)."""
        return np.asarray(self.sweeps.nodes.coefficients(self._responses(effects) - self._plain_responses))

    @cached_property
    def _plain_responses(self) -> Complex:
        return self._responses({})

    def _responses(self, effects: Mapping[str, Values]) -> Complex:
        """Return the recorded FRFs with `effects` at the nodes of every sweep, (T, K, n)."""
        transfer, lines, gains = self.specimen.transfer(effects), self.sweeps.nodes.frequency, self.specimen.gains
        points = [self.state.circumstances(*sweep) for sweep in enumerate(self.sweeps.points)]
        return np.array([gains[p.source] * transfer(p, lines) for p in points])

    def size(self, signal: Complex) -> float:
        """Size of a signal, in sigma: what laws, readings, gain and declared quantities leave, to first order."""
        seen = [
            self.sweeps.rows[k] * self.sweeps.weights.weigh(one.whitened(own), k)
            for k, (one, own) in enumerate(zip(self.sweeps.compressed, signal, strict=True))
        ]
        total = float((np.abs(seen) ** 2).sum())
        return float(np.sqrt(max(total - self._absorbed(np.array(seen)), 0.0))) / self.sigma

    def _absorbed(self, residual: Complex) -> float:
        """Decrease of chi2 by all that may differ without any effect, for a whitened residual (T, K, n)."""
        weights = self.sweeps.weights
        equations = [
            replace(one, white=np.concatenate([weights.weigh(one.white[:-1], k), own[None]])).equations()
            for k, (one, own) in enumerate(zip(self.columns, residual, strict=True))
        ]
        head = schur_complement(self.sweeps, equations, self.state)
        priors = np.concatenate([np.zeros(head.gains), self.declared.precision(self.declared.centre)])
        step = np.linalg.solve(head.matrix + np.diag(priors), head.gradient)
        return head.predicted_decrease + float(head.gradient @ step)

    def scatter(self, effects: Mapping[str, Values]) -> float | None:
        """Scatter of the resonances that `effects` make, frequency and half loss factor together, relative.

        None where they exceed the certified range of the plate's operators.
        """
        found = self._discrepancy(effects)
        return None if found is None else float(np.hypot(found[1].frequency, found[1].damping))

    def beside(self, effects: Mapping[str, Values]) -> "EffectSize":
        """Return a yard in which sigma contains the scatter of the resonances that `effects` make."""
        found = self._discrepancy(effects)
        if found is None:
            raise ValueError(f"{', '.join(effects)}: beyond what the plate is certified for")
        shape, scatter = found
        return replace(self, sweeps=replace(self.sweeps, weights=shape.weights(scatter)))

    def _discrepancy(self, effects: Mapping[str, Values]) -> tuple[DiscrepancyShape, Discrepancy] | None:
        try:
            fit = self._fitted(self._with(self.signal(effects)))
        except ValueError:
            return None
        loss = np.exp(fit.state.laws[self.sweeps.groups.of_sweep, 2])
        shape = DiscrepancyShape.of(self.sweeps, fit.predicted, loss)
        quiet = replace(
            shape,
            by_frequency=QUIETER_NOISE_FACTOR**2 * shape.by_frequency,
            by_amplitude=QUIETER_NOISE_FACTOR**2 * shape.by_amplitude,
        )
        return shape, quiet.scatter(self.sweeps, QUIETER_NOISE_FACTOR * fit.residual, fit.determined)

    def left(self, signal: Complex) -> float:
        """Return the size of a signal, in sigma, after a full fit of laws, readings and gain to it.

        Declared quantities take their part of what that leaves, to first order.
        """
        fit = self._fitted(self._with(signal))
        return float(np.sqrt(max(fit.total - self._absorbed(fit.residual), 0.0))) / self.sigma

    def _fitted(self, seen: GapSweeps) -> GapFit:
        return fit_gap(self.specimen.twin, seen, self.state, (), self.executor)

    def cosine(self, one: Complex, other: Complex) -> float:
        """Return the cosine between two signals, by polarisation of `size`."""
        a, b, both = self.size(one), self.size(other), self.size(one + other)
        return float((both**2 - a**2 - b**2) / (2.0 * a * b))

    def imitations(self, signal: Complex) -> dict[str, float]:
        """Cosine between a signal and the nearest signal of each effect of the library."""
        seen = self._with(signal)
        fit = self._fitted(seen)
        known = [name for name in self.specimen.twin.library if name in LIBRARY]
        screening = score_test(self.specimen.twin, seen, fit, self.executor, effects=known)
        found: dict[str, float] = {}
        for name in screening.inactive:
            for site in screening.sites(name):
                own = screening.of(name, site)
                block, pull = screening.matrix[np.ix_(own, own)], screening.gradient[own]
                scale = 1.0 / np.sqrt(np.maximum(np.diag(block), 1e-300))
                unit = block * scale[:, None] * scale + 1e-9 * np.eye(len(own))
                shared = float((scale * pull) @ np.linalg.solve(unit, scale * pull)) / max(fit.total, 1e-300)
                found[name] = max(found.get(name, 0.0), float(np.sqrt(np.clip(shared, 0.0, 1.0))))
        return found

    def _with(self, signal: Complex) -> GapSweeps:
        """Sweeps of the specimen without effects plus `signal`."""
        compressed = tuple(
            replace(sweep, coefficients=plain + own)
            for sweep, plain, own in zip(self.sweeps.compressed, self._predicted, signal, strict=True)
        )
        return replace(self.sweeps, compressed=compressed)

    @cached_property
    def _predicted(self) -> list[Complex]:
        """Spline coefficients (K, n) of every sweep without effects."""
        plain = linearise_all(self.specimen.twin, self.sweeps, self.state, (), self.executor)
        return [one.predicted for one in plain]


def expected_frf(specimen: Specimen, share: float, rng: np.random.Generator) -> tuple[Frf, float]:
    """FRFs of the specimen without effects, with the noise of H1 averaged over the repeats.

    Parameters
    ----------
    specimen : Specimen
    share : float
        Noise of a line over the response, at the cards, for the first input at a middle temperature.
    rng : numpy.random.Generator
        Of the noise.

    Returns
    -------
    frf : Frf
        In the units recorded.
    noise : float
        Noise on every input of the cards, V rms.
    """
    declared, experiment = specimen.declared, specimen.experiments[0]
    sweep, programme = experiment.sweep, experiment.programme
    rate = declared.acquisition.sample_rate
    generator = drive_signal(sweep, 1.0, rate)
    grid = np.fft.rfftfreq(generator.size, 1.0 / rate).astype(np.float64)
    inside = (grid >= sweep.band[0]) & (grid <= sweep.band[1])
    lines, power = grid[inside], np.abs(np.fft.rfft(generator)[inside]) ** 2 * sweep.repeats / generator.size
    inputs = range(len(declared.inputs))
    places = [
        (source, float(t), leg, level)
        for source in inputs
        for leg in programme.legs
        for t in (programme.temperatures if leg == "up" else programme.temperatures[::-1])
        for level in sweep.levels
    ]
    plain = specimen.transfer({})
    answers = {
        (source, t): specimen.gains[source] * plain(SweepPoint(t, 0.0, 1.0, source), lines)
        for source in inputs
        for t in programme.temperatures
    }
    volts = np.array([one.volts for one in experiment.sensitivities.responses])[:, None]
    drive_volts = experiment.sensitivities.drive.volts
    played = specimen.driven / specimen.gains  # recorded signal of the input per volt of the generator
    middle = volts * played[0] * answers[0, programme.temperatures[len(programme.temperatures) // 2]]
    noise = float(share * np.sqrt(np.mean(np.abs(middle) ** 2) / np.mean(1.0 / power)))
    h = np.array([answers[source, t] for source, t, _, _ in places])
    level = np.array([level for *_, level in places])
    source = np.array([source for source, *_ in places])
    recorded = power * (level * played[source])[:, None, None] ** 2
    variance = noise**2 * (1.0 / volts**2 + np.abs(h / drive_volts) ** 2) / recorded
    spread = rng.standard_normal(h.shape) + 1j * rng.standard_normal(h.shape)
    frf = Frf(
        temperature=np.array([t for _, t, _, _ in places]),
        direction=tuple(leg for _, _, leg, _ in places),
        level=level,
        frequency=lines,
        h=h + np.sqrt(0.5 * variance) * spread,
        variance=variance,
        coherence=np.ones(h.shape),
        excluded=mains_lines(lines, MAINS, generator.size / rate),
        channels=tuple(output.id for output in declared.outputs),
        source=source if len(inputs) > 1 else None,
        sources=tuple(one.id for one in declared.inputs) if len(inputs) > 1 else (),
    )
    return frf, noise


def true_updating(specimen: Specimen, frf: Frf) -> Updated:
    """Return a model-updating result for `frf` with the true values."""
    nothing = np.zeros(len(frf.temperature))
    gains = specimen.gains
    return Updated(
        temperature=frf.temperature,
        material=specimen.laws.at(frf.temperature),
        sigma=MaterialSigma(nothing, nothing, nothing),
        correlation=np.zeros((nothing.size, 4, 4)),
        gain=float(gains[0]),
        sigma_gain=0.0,
        misfit_start=nothing,
        misfit=nothing,
        noise_floor=nothing,
        chi2_per_dof=nothing,
        settled=np.ones(nothing.size, dtype=bool),
        further=np.stack([gains[1:], np.zeros(gains.size - 1)], axis=1) if gains.size > 1 else None,
    )
