"""Predicted FRFs of a campaign on a specimen, with noise, without running the simulated rig."""

import numpy as np

from analysis.material import MaterialSigma
from analysis.protocol.sweep import drive_signal
from analysis.recordings.frf import Frf
from analysis.recordings.mains import mains_lines
from analysis.recordings.sweep_point import SweepPoint
from analysis.updated import Updated
from app.blind_trial.specimen import Specimen

MAINS = 50.0
"""Hz."""


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
