"""Experiments of a trial: protocol, material laws and electronics, drawn for each campaign."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from analysis.channel import Motion
from analysis.experiment import Experiment
from app.blind_trial.plates import PlateKind
from app.files.campaigns.import_recording import joined_declaration
from app.files.declarations.experiment import AcquiredExperiment, experiment_model
from app.files.declarations.simulation_section import Laws

Table = dict[str, Any]

LAW_TEMPERATURES = np.arange(-20.0, 91.0, 10.0)
"""Temperatures at which laws are drawn, degrees Celsius."""
SWEEP, TAPER = 1.0, 0.1
"""Length of a sweep and of each of its fades, s."""
DRIVE_SWEEP: Table = {"kind": "logarithmic", "duration": SWEEP, "taper": TAPER, "tail": 0.3, "repeats": 4}
ACQUISITION: Table = {"module": "NI-9234", "input_resistance": 305e3}
OVEN: Table = {"kind": "watlow-f4t", "port": "simulated", "minimum": -15.0, "maximum": 85.0, "max_rate": 3.0}
PROGRAMME: Table = {
    "approach_rate": 3.0,
    "lead": 4.0,
    "soak_before": 300.0,
    "tolerance": 0.4,
    "poll_interval": 10.0,
}
LIMITS: Table = {"coldest": -20.0, "hottest": 90.0, "coherence": 0.0, "silence": 0.0}
"""What is the same in all experiments of a trial, by section of an experiment's file."""
EXCITER_GAIN = 0.04
"""Gain of an exciter, N/V, per V/V of an amplifier: gives a force of about half a newton."""
FORCE_SENSITIVITY = 1.0
"""Sensitivity of the force sensor with its conditioner, V/N."""
MOTION: dict[Motion, float] = {"acceleration": 0.01, "velocity": 20.0}
"""Sensitivities, V per m/s2 and per m/s: the signals are a few tenths of a volt, like that of the force."""
DRIVE_END_SHARE = 0.44
"""Frequency at which the drive's fade ends, as a share of the sample rate: just within the cards' limit."""


def draw_experiments(
    rng: np.random.Generator, kind: PlateKind, title: str, legs: tuple[str, ...], levels: tuple[float, ...]
) -> tuple[AcquiredExperiment, ...]:
    """Draw a campaign of seven to nine temperatures on a plate, without hidden effects and noise.

    Each of several inputs has an experiment of its own, with another amplifier and other noise, because a rig has
    one output.

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
    tuple of AcquiredExperiment
        One for each of the plate's inputs, with a simulated rig, validated like one read from a file.
    """
    count, every = int(rng.integers(7, 10)), float(rng.integers(5, 8))
    lowest = float(rng.integers(0, 9))
    gain = float(rng.uniform(10.0, 16.0))
    capacitance = round(float(rng.uniform(0.8e-10, 2e-10)), 12)
    driver = _driver(kind, gain * float(rng.uniform(0.95, 1.05)))
    room_temperature = round(float(rng.uniform(18.0, 26.0)), 1)
    ramp_rate = float(rng.choice([0.8, 1.0, 1.2]))
    span = {"lowest": lowest, "highest": lowest + every * (count - 1), "every": every}
    table: Table = {
        "format": "experiment/1",
        "title": title,
        "rig": "simulated",
        **_specimen(kind),
        "acquisition": ACQUISITION | {"input_capacitance": capacitance},
        **driver,
        "cards": _cards(kind),
        "oven": OVEN | {"room_temperature": room_temperature},
        "sweep": DRIVE_SWEEP | {"band": kind.band, "levels": levels},
        "programme": PROGRAMME | span | {"legs": legs, "ramp_rate": ramp_rate},
        "limits": LIMITS | {"patch_voltage": None if kind.drives else 100.0},
    }
    simulation = {"seed": int(rng.integers(2**31)), "gain": _true_gain(kind, gain), "laws": draw_laws(rng)}
    first, *others = kind.inputs
    tables = [table | {"patch": _driven_by(kind, first), "simulation": simulation}]
    for other in others:
        gain = float(rng.uniform(10.0, 16.0))
        own = _driver(kind, gain * float(rng.uniform(0.95, 1.05)))
        simulation = simulation | {"seed": int(rng.integers(2**31)), "gain": _true_gain(kind, gain)}
        tables.append(table | own | {"patch": _driven_by(kind, other), "simulation": simulation})
    return tuple(experiment_model(one).model_validate(one) for one in tables)


def any_declaration(kind: PlateKind) -> Experiment:
    """Declare some campaign on a plate: the reduced models depend only on its geometry and band."""
    return declared(draw_experiments(np.random.default_rng(0), kind, "plate", ("up",), (1.0,)))


def declared(experiments: Sequence[AcquiredExperiment]) -> Experiment:
    """Declare the campaign in which the inputs of all experiments drive in turn."""
    return joined_declaration([one.recorded(one.sample_rate) for one in experiments])


def _specimen(kind: PlateKind) -> Table:
    """Return the tables of the plate, of its drives and sensors, and of what it hangs on."""
    return {
        "plate": kind.plate,
        "drive": [drive.model_dump() | {"sensitivity": FORCE_SENSITIVITY} for drive in kind.drives],
        "sensor": [sensor.model_dump() | {"sensitivity": MOTION[sensor.kind]} for sensor in kind.sensors],
        "string": kind.strings,
        "cable": kind.cables,
    }


def _cards(kind: PlateKind) -> Table:
    """Return the table of the cards, with one input per sensor."""
    sensors = sum(patch.role == "sensor" for patch in kind.patches) + len(kind.sensors)
    return {
        "sample_rate": _sample_rate(kind.band),
        "output": "cDAQ1Mod2/ao0",
        "drive_input": "cDAQ1Mod1/ai0",
        "responses": tuple(f"cDAQ1Mod1/ai{1 + k}" for k in range(sensors)),
        "thermocouples": ("cDAQ1Mod3/ai0",),
    }


def _driven_by(kind: PlateKind, name: str) -> list[Table]:
    """Return the patches; drive patches not in use are short-circuited."""
    return [
        patch.model_dump(exclude_none=True)
        | ({"role": "shorted"} if patch.role == "actuator" and patch.id != name else {})
        for patch in kind.patches
    ]


def _driver(kind: PlateKind, gain: float) -> Table:
    """Return the table of the amplifier with this gain, or of the exciter instead."""
    if kind.drives:
        return {"exciter": {"gain": round(EXCITER_GAIN * gain, 3), "rated_force": 5.0}}
    return {"amplifier": {"gain": round(gain, 1)}}


def _true_gain(kind: PlateKind, gain: float) -> float:
    return EXCITER_GAIN * gain if kind.drives else gain


def draw_laws(rng: np.random.Generator) -> Laws:
    """Draw laws of a thermoplastic with a glass transition: E falls, and the loss factor has its maximum there."""
    middle, width = float(rng.uniform(10.0, 35.0)), float(rng.uniform(10.0, 16.0))
    softened = 1.0 / (1.0 + np.exp(-(LAW_TEMPERATURES - middle) / width))
    stiffness = rng.uniform(2.5e9, 3.4e9) * np.exp(-rng.uniform(0.5, 0.95) * softened)
    poisson = rng.uniform(0.33, 0.36) + rng.uniform(0.05, 0.09) * softened
    peak = np.exp(-0.5 * ((LAW_TEMPERATURES - middle) / (1.6 * width)) ** 2)
    loss = rng.uniform(0.03, 0.05) + rng.uniform(0.01, 0.035) * peak
    return Laws(
        temperature=tuple(LAW_TEMPERATURES.tolist()),
        youngs_modulus=tuple(stiffness.tolist()),
        poisson_ratio=tuple(poisson.tolist()),
        loss_factor=tuple(loss.tolist()),
    )


def _sample_rate(band: tuple[float, float]) -> float:
    """Smallest sample rate for the drive with its fade, Hz."""
    low, high = band
    fade = np.exp(np.log(high / low) * TAPER / (SWEEP - 2.0 * TAPER))
    return float(high * fade / DRIVE_END_SHARE)
