"""How large a hidden effect is in a campaign: in sigma, after everything else has absorbed what it can.

A sigma is what the comparison goes by: that of the noise and of the twin's own error, common to all lines.
"""

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Complex
from analysis.effect_card import Values
from analysis.frf import Frf
from analysis.gap.data.preparation import prepare
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.fitting.normal_equations import linearise_all
from analysis.gap.fitting.schur_complement import schur_complement
from analysis.gap.fitting.state import GapState, starting_state
from analysis.gap.search.score_test import score_test
from analysis.mains import mains_lines
from analysis.material import Material
from analysis.protocol.drive import drive_signal
from analysis.sweep_point import SweepPoint
from analysis.updated import Updated
from app.blind_trial.specimen import Specimen
from app.rig.plate_transfer import PlateTransfer
from simulation.effects.library import LIBRARY

MAINS = 50.0


@dataclass(frozen=True)
class EffectSize:
    """A campaign as it would be recorded from the plain specimen, linearised there.

    Attributes
    ----------
    specimen : Specimen
    sweeps : GapSweeps
    state : GapState
        Laws and gain as they are.
    noise : float
        V rms on every input.
    executor : Executor
    """

    specimen: Specimen
    sweeps: GapSweeps
    state: GapState
    noise: float
    executor: Executor

    @classmethod
    def of(
        cls,
        specimen: Specimen,
        share: float,
        rng: np.random.Generator,
        executor: Executor,
    ) -> "EffectSize":
        """Choose the noise by its share of the response in the FRF of a mean sweep.

        Parameters
        ----------
        specimen : Specimen
        share : float
            0.01 is 1 % of the response on a line.
        rng : numpy.random.Generator
            Of the noise.
        executor : Executor
            Works through the sweeps.

        Returns
        -------
        EffectSize
        """
        frf, noise = _expected_frf(specimen, share, rng)
        updated = _as_updated(specimen, frf)
        sweeps = prepare(frf, specimen.declared.protocol, updated)[0]
        return cls(specimen, sweeps, starting_state(updated, sweeps.groups), noise, executor)

    @property
    def sigma(self) -> float:
        """Of noise and the twin's own error along any one effect, in sigma of the noise."""
        return float(np.sqrt(self.sweeps.overstated))

    def signal(self, effects: Mapping[str, Values]) -> Complex:
        """Return what `effects` add to the recorded FRFs, as spline coefficients (T, K, n), V/V."""
        plain, other = self.specimen.transfer({}), self.specimen.transfer(effects)
        lines = self.sweeps.nodes.frequency
        added = np.array([other(p, lines) - plain(p, lines) for p in self.sweeps.points])
        return np.asarray(float(np.exp(self.state.log_gain[0])) * self.sweeps.nodes.coefficients(added))

    def size(self, signal: Complex) -> float:
        """Of a signal, in sigma, once laws, readings and gain have taken what they can of it, to first order."""
        seen = self._with(signal)
        equations = linearise_all(self.specimen.twin, seen, self.state, (), self.executor)
        head = schur_complement(seen, equations, self.state)
        chi2 = (
            sum(e.chi2 for e in equations)
            - head.predicted_decrease
            - float(head.gradient[0] ** 2 / head.matrix[0, 0])
        )
        return float(np.sqrt(max(chi2, 0.0))) / self.sigma

    def left(self, signal: Complex) -> float:
        """Return the size of a signal once laws, readings and gain are fitted to it, however far they move."""
        return float(np.sqrt(self._fitted(self._with(signal)).total)) / self.sigma

    def _fitted(self, seen: GapSweeps) -> GapFit:
        return fit_gap(self.specimen.twin, seen, self.state, (), self.executor)

    def cosine(self, one: Complex, other: Complex) -> float:
        """Return the cosine between two signals, by polarisation of `size`."""
        a, b, both = self.size(one), self.size(other), self.size(one + other)
        return float((both**2 - a**2 - b**2) / (2.0 * a * b))

    def imitations(self, signal: Complex) -> dict[str, float]:
        """Cosine between a signal and the nearest to it that each effect of the library can make."""
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
        """Sweeps in which `signal` is all that the plain specimen does not explain."""
        plain = linearise_all(self.specimen.twin, self.sweeps, self.state, (), self.executor)
        compressed = tuple(
            replace(sweep, coefficients=e.predicted + own)
            for sweep, e, own in zip(self.sweeps.compressed, plain, signal, strict=True)
        )
        return replace(self.sweeps, compressed=compressed)


def _expected_frf(specimen: Specimen, share: float, rng: np.random.Generator) -> tuple[Frf, float]:
    """FRFs of the plain specimen with the noise that H1 over the repeats leaves, and the inputs' noise."""
    sweep, programme = specimen.experiment.sweep, specimen.experiment.programme
    rate, gain = specimen.declared.acquisition.sample_rate, specimen.gain
    drive = drive_signal(sweep, 1.0, rate)
    grid = np.fft.rfftfreq(drive.size, 1.0 / rate).astype(np.float64)
    inside = (grid >= sweep.band[0]) & (grid <= sweep.band[1])
    lines, power = grid[inside], np.abs(np.fft.rfft(drive)[inside]) ** 2 * sweep.repeats / drive.size
    places = [
        (float(t), leg, level)
        for leg in programme.legs
        for t in (programme.temperatures if leg == "up" else programme.temperatures[::-1])
        for level in sweep.levels
    ]
    plain: PlateTransfer = specimen.transfer({})
    answers = {t: gain * plain(SweepPoint(t, 0.0, 1.0), lines) for t in programme.temperatures}
    middle = answers[programme.temperatures[len(answers) // 2]]
    noise = float(share * np.sqrt(np.mean(np.abs(middle) ** 2) / np.mean(1.0 / power)))
    h = np.array([answers[t] for t, _, _ in places])
    level = np.array([level for _, _, level in places])
    variance = noise**2 * (1.0 + np.abs(h) ** 2) / power / level[:, None, None] ** 2
    spread = rng.standard_normal(h.shape) + 1j * rng.standard_normal(h.shape)
    frf = Frf(
        temperature=np.array([t for t, _, _ in places]),
        direction=tuple(leg for _, leg, _ in places),
        level=level,
        frequency=lines,
        h=h + np.sqrt(0.5 * variance) * spread,
        variance=variance,
        coherence=np.ones(h.shape),
        excluded=mains_lines(lines, MAINS, drive.size / rate),
        channels=tuple(output.id for output in specimen.declared.outputs),
    )
    return frf, noise


def _as_updated(specimen: Specimen, frf: Frf) -> Updated:
    """Model updating as if it had found the truth."""
    nothing = np.zeros(len(frf.temperature))
    return Updated(
        temperature=frf.temperature,
        material=specimen.laws.at(frf.temperature),
        sigma=Material(nothing, nothing, nothing),
        correlation=np.zeros((nothing.size, 4, 4)),
        gain=specimen.gain,
        sigma_gain=0.0,
        misfit_start=nothing,
        misfit=nothing,
        noise_floor=nothing,
        chi2_per_dof=nothing,
        settled=np.ones(nothing.size, dtype=bool),
    )
