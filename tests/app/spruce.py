"""A spruce plate recorded on the simulated rig, of another mesh than the twin's; not all of it is declared.

Constants, lengths and mass are those published for a plate of tonewood (Badiane, Malvermi, Gonzalez, Antonacci,
Sarti: plate 5L): Ex/Ey is 12.1. The loss along the grain is a third of that across; the shear modulus of the plane
yz, which is not declared, is a tenth of that in the plane.
"""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from click.testing import CliRunner
from threadpoolctl import threadpool_limits

from app.blind_trial.plates import OTHER_MESH
from app.files.declarations.experiment import AcquiredExperiment, read_acquired_experiment
from app.files.effect_cache import cached_departures
from app.files.settings_toml import toml_text
from app.main import flexura
from simulation.tolerances import tolerances
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "exciter.toml"
TRUE = {"youngs_modulus_x": 12.1e9, "youngs_modulus_y": 0.999e9, "shear_modulus": 0.798e9}
WRONG = {"youngs_modulus_x": 1.15, "youngs_modulus_y": 0.85, "shear_modulus": 0.85}
TRANSVERSE = [0.75e9, 0.08e9]
NU_XY, LOSS = 0.471, {"x": 0.009, "y": 0.027, "shear": 0.018}
TEMPERATURE = np.array([5.0, 12.0, 19.0, 26.0, 33.0])
SOFTENING = 1.0 - 0.002 * (TEMPERATURE - 20.0)
BOX = {"youngs_modulus": [3e9, 13e9], "poisson_ratio": [0.02, 0.35], "loss_factor": [0.004, 0.08]}
HIDDEN = {
    "sheet_loss": {
        "ratio": float(np.log(LOSS["y"] / LOSS["x"])),
        "shear": float(np.log(LOSS["shear"] / np.sqrt(LOSS["x"] * LOSS["y"]))),
    },
    "plate_thickness": {"share": 0.004},
    "transducer_place acc": {"dx": 4e-4, "dy": -3e-4},
}
"""What the plate has and the declaration does not say, within its tolerances but for the losses."""


class Recorded(Twin[EffectPlate]):
    """The plate that is recorded."""

    def uncertified_frf(self, laws, frequency, effects=None, point=None):  # type: ignore[no-untyped-def]
        """Return its transfer with what is hidden."""
        return super().uncertified_frf(laws, frequency, {**HIDDEN, **(effects or {})}, point)


def run(*words: object) -> Any:
    with threadpool_limits(1):
        return CliRunner().invoke(flexura, [str(word) for word in words])


def declaration(orthotropy: Mapping[str, Any], accelerometer: float, noise: float | None) -> dict[str, Any]:
    """Return the experiment as a table: the example's rig around a plate of spruce."""
    table = tomllib.loads(EXAMPLE.read_text(encoding="utf-8"))
    mean, ratio = (
        0.5 * (TRUE["youngs_modulus_x"] + TRUE["youngs_modulus_y"]),
        TRUE["youngs_modulus_y"] / TRUE["youngs_modulus_x"],
    )
    nu = NU_XY * float(np.sqrt(ratio))
    del table["patch"]
    table["plate"] = {
        **{"length_x": 0.5814, "length_y": 0.2176, "thickness": 0.005, "mass": 0.2728},
        "material": {**BOX, "orthotropy": orthotropy},
    }
    table["drive"][0]["point"] = [0.03, 0.03]
    table["sensor"] = [
        {**table["sensor"][0], "point": [0.5514, 0.1876], "side": "top", "mass": accelerometer},
        {**table["sensor"][1], "sensitivity": 5.0, "points": [[0.25, 0.06], [0.40, 0.20]]},
    ]
    table["cards"]["responses"] = ["cDAQ1Mod1/ai1", "cDAQ1Mod1/ai2", "cDAQ1Mod1/ai3"]
    table["sweep"] |= {"band": [60.0, 600.0], "duration": 4.0, "tail": 5.0, "levels": [0.5]}
    table["programme"] |= {"lowest": 15.0, "highest": 25.0, "every": 5.0}
    table["simulation"] |= {} if noise is None else {"noise": noise}
    table["simulation"]["laws"] = {
        "temperature": TEMPERATURE.tolist(),
        "youngs_modulus": (mean * SOFTENING).tolist(),
        "poisson_ratio": [nu] * len(TEMPERATURE),
        "loss_factor": [float(np.sqrt(LOSS["x"] * LOSS["y"]))] * len(TEMPERATURE),
    }
    return table


def written(
    folder: Path,
    name: str,
    orthotropy: Mapping[str, Any],
    *,
    accelerometer: float = 0.0022,
    noise: float | None = None,
) -> AcquiredExperiment:
    """Write the experiment's file, and read it; `accelerometer` is a mass in kg, `noise` in V rms."""
    path = folder / f"{name}.toml"
    path.write_text(toml_text(declaration(orthotropy, accelerometer, noise), ""), encoding="utf-8")
    return read_acquired_experiment(path)


def specimen(experiment: AcquiredExperiment) -> Recorded:
    """Return the plate with its true moduli, on another mesh than the twin of the analysis."""
    recorded = experiment.recorded(experiment.sample_rate)
    material = recorded.plate.material
    assert material is not None
    operators = cached_departures(recorded, material.box, lambda stage, share: None, OTHER_MESH)
    return Recorded.of(recorded, EffectPlate(operators), tolerances=tolerances(recorded, operators.movable))
