"""The simulated rig's plate with effects, against the twin that computes them, on a small plate of few modes."""

from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.experiment import Acquisition, Attachment, Experiment, OvenDeclaration, Patch, Plate, Protocol
from analysis.material import Material, MaterialBox, laws_through
from analysis.protocol.sweep import SweepSettings, drive_signal
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import Effects
from app.files.campaign_error import CampaignFileError
from app.files.declarations.experiment import read_acquired_experiment
from app.files.declarations.simulation_section import Laws
from app.rig import simulated_rig as rig
from app.rig.simulated_plate import TwinPlate, TwinTransfer
from simulation.effects.library import LIBRARY
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.effect_reduction import reduce_with_effects
from simulation.reduction.vectors.reduce import reduce
from simulation.shell.assembly import assemble_for
from simulation.shell.fineness import Fineness
from simulation.twin.declared_plate import DeclaredPlate
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "hidden-effect.toml"
TABLE = np.linspace(-10.0, 70.0, 9)
RATE = 51_200.0 / 24.0
BAND = (100.0, 400.0)
BOX = MaterialBox((1.5e9, 3e9), (0.34, 0.42), (0.03, 0.1))
MESH = MeshRecipe(spacing=0.08, strip=1.5, edge_strip=1.5, growth=2.0, grading=0.0, pieces=1)
COARSE = Fineness(MESH, degree=3, tolerance=0.0)
T = np.linspace(0.0, 40.0, 5)
LAWS = laws_through(T, Material(2.7e9 * np.exp(-0.01 * T), 0.36 + 0.001 * T, np.full(5, 0.05)))
SWEEP = SweepSettings(kind="logarithmic", band=BAND, duration=2.0, taper=0.1, tail=0.4, repeats=1, levels=(1.0,))
LINES = np.linspace(*BAND, 301)
MASS = MappingProxyType({"point_mass": {"mass": 0.002}})


@pytest.fixture(scope="module")
def experiment() -> Experiment:
    return Experiment(
        title="hidden effects",
        plate=Plate(length_x=0.24, length_y=0.19, thickness=0.003, mass=0.12996),
        patch=(
            Patch(id="A1", role="actuator", center=(0.2, 0.155), size=(0.02, 0.02), thickness=0.0005),
            Patch(id="S1", role="sensor", center=(0.04, 0.035), size=(0.02, 0.02), thickness=0.0005),
        ),
        cable=(Attachment(point=(0.058, 0.03)),),
        acquisition=Acquisition(
            module="NI-9234", sample_rate=RATE, input_resistance=305e3, input_capacitance=120e-12
        ),
        protocol=Protocol(
            sweep="logarithmic",
            band=BAND,
            sweep_duration=2.0,
            tail=0.4,
            repeats=1,
            ramp_rate=0.4,
            temperatures=(10.0, 30.0),
            directions=("up",),
            levels=(1.0,),
        ),
        oven=OvenDeclaration(room_temperature=22.0),
    )


@pytest.fixture(scope="module")
def twin(experiment: Experiment) -> Twin[EffectPlate]:
    operators = reduce_with_effects(experiment, BOX, fineness=COARSE)[0]
    names = ("thermal_lag", "point_mass", "amplitude_softening")
    return Twin.of(experiment, EffectPlate(operators), {name: LIBRARY[name] for name in names})


def of(twin: Twin[EffectPlate], effects: Effects) -> TwinTransfer:
    return TwinTransfer(twin.referred(LAWS.local(25.0)), LAWS, effects)


def lines_of(drive: Real) -> Real:
    grid = np.arange(drive.size // 2 + 1) * (RATE / drive.size)
    return np.asarray(grid[(grid > BAND[0]) & (grid < BAND[1])])


def ratio(plate: TwinPlate, drive: Real, temperature: Real) -> NDArray[np.complex128]:
    """Spectrum of the answer over the drive's, in the band."""
    grid = np.arange(drive.size // 2 + 1) * (RATE / drive.size)
    inside = (grid > BAND[0]) & (grid < BAND[1])
    answer = plate(drive, RATE, temperature)
    return np.asarray(np.fft.rfft(answer[0])[inside] / np.fft.rfft(drive)[inside])


def difference(one: NDArray[np.complex128], other: NDArray[np.complex128]) -> float:
    return float(np.linalg.norm(one - other) / np.linalg.norm(other))


def test_without_any_effect_it_is_the_plain_plate(twin: Twin[EffectPlate], experiment: Experiment) -> None:
    plain = reduce(assemble_for(experiment.plate, experiment.patch, BOX, BAND, fineness=COARSE), BOX, BAND)[0]
    without = TwinTransfer(Twin.of(experiment, DeclaredPlate(plain)), LAWS)
    drive = drive_signal(SWEEP, 1.0, RATE)
    temperature = np.full(drive.size, 20.0)
    answer = TwinPlate(of(twin, {}), 15.0)(drive, RATE, temperature)
    expected = TwinPlate(without, 15.0)(drive, RATE, temperature)
    assert np.sqrt(np.mean((answer - expected) ** 2) / np.mean(expected**2)) < 2e-3


def test_a_sweep_finds_the_point_mass_that_the_twin_computes(twin: Twin[EffectPlate]) -> None:
    drive = drive_signal(SWEEP, 1.0, RATE)
    lines = lines_of(drive)
    laws = LAWS.local(20.0)
    expected = twin.frf(laws, lines, MASS, SweepPoint(20.0, 0.0, 1.0))[0]
    found = ratio(TwinPlate(of(twin, MASS), 15.0), drive, np.full(drive.size, 20.0)) / 15.0
    assert difference(found, expected) < 2e-3
    assert difference(twin.frf(laws, lines, point=SweepPoint(20.0, 0.0, 1.0))[0], expected) > 0.05


def test_a_lag_is_the_plate_as_it_was_before(twin: Twin[EffectPlate]) -> None:
    """Colder by tau dT/dt on the way up, warmer on the way down, and the laws followed there, not a tangent."""
    tau = 600.0
    lagging = of(twin, {"thermal_lag": {"tau": tau}})
    for rate in (0.01, -0.01):
        steady = of(twin, {})(SweepPoint(20.0 - tau * rate, 0.0, 1.0), LINES)
        np.testing.assert_allclose(lagging(SweepPoint(20.0, rate, 1.0), LINES), steady, rtol=1e-9)
    with pytest.raises(ValueError, match="outside the laws' range"):
        lagging(SweepPoint(5.0, 0.01, 1.0), LINES)


def test_softening_follows_the_level_and_the_plain_plate_does_not(twin: Twin[EffectPlate]) -> None:
    drive = drive_signal(SWEEP, 1.0, RATE)
    temperature = np.full(drive.size, 20.0)
    soft = TwinPlate(of(twin, {"amplitude_softening": {"a": 0.05, "b": 0.1}}), 15.0)
    once, twice = ratio(soft, drive, temperature), ratio(soft, 2.0 * drive, temperature)
    assert difference(twice, once) > 0.02
    hard = TwinPlate(of(twin, {}), 15.0)
    assert difference(ratio(hard, 2.0 * drive, temperature), ratio(hard, drive, temperature)) < 1e-9


ASKED: list[dict[str, object]] = []
"""How `hidden` asked for the twin, the last time last."""


def hidden(
    twin: Twin[EffectPlate], monkeypatch: pytest.MonkeyPatch, effects: dict[str, dict[str, float]]
) -> TwinPlate:
    """Return the plate of the example's rig, with other effects, its laws within the small twin's range."""
    monkeypatch.setattr(rig, "effect_twin", lambda *_, **asked: ASKED.append(asked) or twin)
    found = read_acquired_experiment(EXAMPLE)
    assert found.simulation is not None
    values = {"youngs_modulus": 2.7e9 * np.exp(-0.005 * TABLE), "poisson_ratio": 0.36 + 0.0005 * TABLE}
    columns = {name: tuple(map(float, value)) for name, value in values.items()}
    laws = Laws(temperature=tuple(map(float, TABLE)), loss_factor=(0.05,) * TABLE.size, **columns)
    simulation = found.simulation.model_copy(update={"effects": effects, "laws": laws})
    parts = rig.simulated_rig(found.model_copy(update={"simulation": simulation}), EXAMPLE, lambda *_: None)
    plate = parts.server.chassis.surroundings.plate
    assert isinstance(plate, TwinPlate)
    return plate


def test_the_rig_hangs_the_plate_with_its_effects_on_the_cards(
    twin: Twin[EffectPlate], monkeypatch: pytest.MonkeyPatch
) -> None:
    plate = hidden(twin, monkeypatch, {"point_mass": {"mass": 0.002}})
    assert plate.gain == 13.7
    assert ASKED[-1]["offset"] is False  # the twin that `flexura gap` makes, and keeps
    drive = drive_signal(SWEEP, 1.0, RATE)
    found = ratio(plate, drive, np.full(drive.size, 20.0)) / plate.gain
    laws = plate.transfer.laws  # type: ignore[attr-defined]
    expected = twin.frf(laws.local(20.0), lines_of(drive), MASS, SweepPoint(20.0, 0.0, 1.0))[0]
    assert difference(found, expected) < 2e-3


@pytest.mark.parametrize(
    ("effects", "told"),
    [
        ({"sensor_offset": {"dx": 1e-4, "dy": 0.0}}, r"effects.sensor_offset = .*no room for"),
        ({"thermal_lag": {"tau": 900.0}}, r"on the way up: temperature .* outside the laws' range"),
    ],
)
def test_the_rig_refuses_before_the_oven_is_started(
    twin: Twin[EffectPlate], monkeypatch: pytest.MonkeyPatch, effects: dict[str, dict[str, float]], told: str
) -> None:
    with pytest.raises(CampaignFileError, match=told):
        hidden(twin, monkeypatch, effects)
