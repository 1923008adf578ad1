"""Record examples/hammer-plate anew: python docs/make_hammer_example.py [FOLDER].

A simulated hammer test of the plate declared in examples/hammer-plate/campaign.toml. The plate that is hit lies on
cells of its own and keeps functions that no twin of the program keeps, so that a twin has the difference to bear.
"""

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

from analysis.arrays import Real
from analysis.experiment import Experiment
from analysis.material import LocalLaws, MaterialBox
from app.files.campaigns.channels import read_experiment
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.plate_basis import reduce_with_footprints
from simulation.shell.assembly import assemble_for
from simulation.shell.fineness import Fineness
from simulation.twin.declared_plate import DeclaredPlate
from simulation.twin.twin import Twin

Laws = Callable[[float], tuple[float, float, float]]

EXAMPLE = Path(__file__).resolve().parents[1] / "examples" / "hammer-plate"
SEED = 11
FINE = Fineness(MeshRecipe(spacing=0.027, strip=0.6, edge_strip=0.7, growth=1.0), degree=9, tolerance=3e-10)
"""Twins lie on cells of 40 and 34 mm, of degree 8, and drop functions below 3e-9 and 1e-9."""
PULSE = 3.5e-4
"""Half width of a hit at 1/e of its height, s: a tip of nylon."""
SPREAD = 0.15
"""Of the heights of hits, relative."""
CALIBRATION = 1.013
"""Of the accelerometers over that of the force cell."""
NOISE = {"N": 1e-3, "m/s2": 0.06, "m/s": 2e-5, "V": 3e-4}
"""Rms of a channel, in its unit."""
READING = 0.05
"""Of an oven reading, K."""
BEYOND = (0.3, 1.6)
"""Where recorders' filters end, as shares of the band's edges: a free plate that is hit drifts away for ever."""
HIT = (0.14, 0.16)
"""When a hit comes, s: what such filters send ahead of it has died away at the beginning of the record."""


def material(temperature: float) -> tuple[float, float, float]:
    """E [Pa], nu and eta of the sheet as it hangs, at a temperature in degrees Celsius."""
    warmer = temperature - 20.0
    return 70.3e9 * (1.0 - 5.2e-4 * warmer), 0.332 + 4e-5 * warmer, 5.0e-3 * (1.0 + 6e-3 * warmer)


def plate(made: Experiment, laws: Laws = material) -> Twin:
    """Return the plate that is hit, over more than the band: what lies beyond its ends is hit, too."""
    known = np.array([laws(t) for t in made.protocol.temperatures])
    edges = np.stack([0.995 * known.min(0), 1.005 * known.max(0)], axis=1)
    box = MaterialBox(*((float(low), float(high)) for low, high in edges))
    low, high = made.protocol.band
    band = (BEYOND[0] * low, BEYOND[1] * high)
    model = assemble_for(made.plate, made.patch, box, band, footprints=made.footprints, fineness=FINE)
    return Twin.of(made, DeclaredPlate(reduce_with_footprints(model, box, band, made.footprints)[0]))


def hits(
    declared: Experiment, twin: Twin, constants: tuple[float, float, float], rng: np.random.Generator
) -> list[dict[str, Real]]:
    """Return the channels of every hit on a plate of E [Pa], nu and eta, as recorded."""
    protocol, rate = declared.protocol, declared.acquisition.sample_rate
    count = round((protocol.sweep_duration + protocol.tail) * rate)
    grid = np.fft.rfftfreq(2 * count, 1.0 / rate)  # what still rings at the end is cut off, not wrapped round
    low, high = twin.band
    inside = (grid >= low) & (grid <= high)
    lines = grid[inside]
    rising, falling = (
        0.5 - 0.5 * np.cos(np.pi * np.clip((lines - far) / (near - far), 0.0, 1.0))
        for near, far in zip(protocol.band, twin.band, strict=True)
    )
    outputs = declared.outputs
    answers = np.zeros((twin.outputs, grid.size), complex)
    answers[:, inside] = rising * falling * twin.frf(LocalLaws.of_material(*constants), lines)
    time = np.arange(2 * count) / rate
    recorded = []
    for _ in range(protocol.repeats):
        height = protocol.levels[0] * (1.0 + SPREAD * rng.uniform(-1.0, 1.0))
        force = height * np.exp(-(((time - rng.uniform(*HIT)) / PULSE) ** 2))
        moved = CALIBRATION * np.fft.irfft(answers * np.fft.rfft(force), 2 * count)
        true = [force, *moved[: len(outputs)]]
        units = ["N", *(output.unit for output in outputs)]
        names = ["drive", *(output.id for output in outputs)]
        recorded.append(
            {
                name: signal[:count] + NOISE[unit] * rng.standard_normal(count)
                for name, signal, unit in zip(names, true, units, strict=True)
            }
        )
    return recorded


def write_sweep(
    path: Path, declared: Experiment, root: Mapping[str, Any], recorded: list[dict[str, Real]]
) -> None:
    """Write one TDMS file as a recorder does."""
    units = {"drive": "N"} | {output.id: output.unit for output in declared.outputs}
    parts: list[Any] = [RootObject(dict(root))]
    for number, channels in enumerate(recorded, 1):
        parts.append(GroupObject(f"repeat {number}"))
        for name, samples in channels.items():
            wave = {
                "wf_increment": 1.0 / declared.acquisition.sample_rate,
                "wf_start_offset": 0.0,
                "wf_samples": samples.size,
                "unit_string": units[name],
            }
            parts.append(ChannelObject(f"repeat {number}", name, samples.astype(np.float32), wave))
    with TdmsWriter(path) as writer:
        writer.write_segment(parts)


def record(declared: Experiment, folder: Path, made: Experiment | None = None, laws: Laws = material) -> None:
    """Write the sweeps of a hammer test into a folder.

    Parameters
    ----------
    declared : Experiment
    folder : Path
        Of the campaign; made if it is not there.
    made : Experiment, optional
        The plate as it is, where the declaration does not say all: its first outputs are the declared ones.
    laws : callable, optional
        Temperature -> E, nu, eta.
    """
    rng = np.random.default_rng(SEED)
    twin = plate(made or declared, laws)
    (folder / "sweeps").mkdir(parents=True, exist_ok=True)
    for step, temperature in enumerate(declared.protocol.temperatures):
        start, end = (float(temperature + READING * reading) for reading in rng.standard_normal(2))
        root = {
            "oven_temperature_start": start,
            "oven_temperature_end": end,
            "direction": "up",
            "level": declared.protocol.levels[0],
            "step": step,
            "start_time": f"2026-01-05T{8 + step:02d}:00:00",
        }
        path = folder / "sweeps" / f"{step:03d}_up_{temperature:+05.1f}C.tdms"
        write_sweep(path, declared, root, hits(declared, twin, laws(temperature), rng))


if __name__ == "__main__":
    record(read_experiment(EXAMPLE), Path(sys.argv[1]) if len(sys.argv) > 1 else EXAMPLE)
