"""Campaigns of a trial: protocol, material laws, electronics, all drawn anew for each."""

from typing import Any

import numpy as np

from app.blind_trial.plates import PlateKind
from app.files.experiment_toml import AcquiredExperiment, experiment_model
from app.files.simulation_section import Laws

TABLE = np.arange(-20.0, 91.0, 10.0)
"""Degrees Celsius at which laws are drawn."""
SWEEP, TAPER, TAIL, REPEATS = 1.0, 0.1, 0.3, 4
ALIAS_FREE = 0.44
"""Share of the sample rate at which the drive's fade ends: just inside what the cards allow."""


def draw_experiment(
    rng: np.random.Generator, kind: PlateKind, title: str, legs: tuple[str, ...], levels: tuple[float, ...]
) -> AcquiredExperiment:
    """Draw a campaign of seven to nine temperatures on a plate; what is hidden is not in it, nor the noise.

    Parameters
    ----------
    rng : numpy.random.Generator
    kind : PlateKind
    title : str
    legs : tuple of str
        Directions of the programme's legs.
    levels : tuple of float
        Of the drive, V.

    Returns
    -------
    AcquiredExperiment
        Of a simulated rig, checked as one read from a file.
    """
    count, every = int(rng.integers(7, 10)), float(rng.integers(5, 8))
    lowest = float(rng.integers(0, 9))
    gain = float(rng.uniform(10.0, 16.0))
    sweep = {"kind": "logarithmic", "band": kind.band, "duration": SWEEP, "taper": TAPER, "tail": TAIL}
    sensors = sum(patch.role == "sensor" for patch in kind.patches)
    table: dict[str, Any] = {
        "format": "experiment/1",
        "title": title,
        "rig": "simulated",
        "plate": kind.plate,
        "patch": [patch.model_dump(exclude_none=True) for patch in kind.patches],
        "string": kind.strings,
        "cable": kind.cables,
        "acquisition": {
            "module": "NI-9234",
            "input_resistance": 305e3,
            "input_capacitance": round(float(rng.uniform(0.8e-10, 2e-10)), 12),
        },
        "amplifier": {"gain": round(gain * float(rng.uniform(0.95, 1.05)), 1)},
        "cards": {
            "sample_rate": _sample_rate(kind.band),
            "output": "cDAQ1Mod2/ao0",
            "drive_input": "cDAQ1Mod1/ai0",
            "responses": tuple(f"cDAQ1Mod1/ai{1 + k}" for k in range(sensors)),
            "thermocouples": ("cDAQ1Mod3/ai0",),
        },
        "oven": {
            "kind": "watlow-f4t",
            "port": "simulated",
            "minimum": -15.0,
            "maximum": 85.0,
            "max_rate": 3.0,
            "room_temperature": round(float(rng.uniform(18.0, 26.0)), 1),
        },
        "sweep": {**sweep, "repeats": REPEATS, "levels": levels},
        "programme": _programme(rng, lowest, every, count, legs),
        "limits": {
            "coldest": -20.0,
            "hottest": 90.0,
            "patch_voltage": 100.0,
            "coherence": 0.0,
            "silence": 0.0,
        },
        "simulation": {"seed": int(rng.integers(2**31)), "gain": gain, "laws": draw_laws(rng)},
    }
    return experiment_model(table).model_validate(table)


def _programme(
    rng: np.random.Generator, lowest: float, every: float, count: int, legs: tuple[str, ...]
) -> dict[str, object]:
    return {
        "lowest": lowest,
        "highest": lowest + every * (count - 1),
        "every": every,
        "legs": legs,
        "ramp_rate": float(rng.choice([0.8, 1.0, 1.2])),
        "approach_rate": 3.0,
        "lead": 4.0,
        "soak_before": 300.0,
        "tolerance": 0.4,
        "poll_interval": 10.0,
    }


def draw_laws(rng: np.random.Generator) -> Laws:
    """Draw laws of a thermoplastic that softens through its glass transition, where its loss peaks."""
    middle, width = float(rng.uniform(10.0, 35.0)), float(rng.uniform(10.0, 16.0))
    softened = 1.0 / (1.0 + np.exp(-(TABLE - middle) / width))
    stiffness = rng.uniform(2.5e9, 3.4e9) * np.exp(-rng.uniform(0.5, 0.95) * softened)
    poisson = rng.uniform(0.33, 0.36) + rng.uniform(0.05, 0.09) * softened
    peak = np.exp(-0.5 * ((TABLE - middle) / (1.6 * width)) ** 2)
    loss = rng.uniform(0.03, 0.05) + rng.uniform(0.01, 0.035) * peak
    return Laws(
        temperature=tuple(TABLE.tolist()),
        youngs_modulus=tuple(stiffness.tolist()),
        poisson_ratio=tuple(poisson.tolist()),
        loss_factor=tuple(loss.tolist()),
    )


def _sample_rate(band: tuple[float, float]) -> float:
    """Just enough for the drive with its fade, Hz."""
    low, high = band
    fade = np.exp(np.log(high / low) * TAPER / (SWEEP - 2.0 * TAPER))
    return float(high * fade / ALIAS_FREE)
