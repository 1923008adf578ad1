"""Moduli and losses of a declared sheet by direction: derivatives, the changed declaration, a start far away."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.estimates import LOSS, MODULI, TRANSVERSE
from analysis.experiment import Experiment
from analysis.material import LocalLaws
from analysis.recordings.frf import Frf
from analysis.recordings.sweep_point import SweepPoint
from analysis.updating.sheet_start import sheet_start
from simulation.effects.library import LIBRARY, library, untried
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.effect_reduction import reduce_with_departures
from simulation.shell.fineness import Fineness
from simulation.tolerances import tolerances
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

BAND = (60.0, 400.0)
LINES = np.linspace(*BAND, 1361)
POINT = SweepPoint(22.0, 0.0, 1.0)
LAWS = LocalLaws.of_material(6.4e9, 0.13, 0.015, reference=22.0)
TRUE = {"youngs_modulus_x": 12e9, "youngs_modulus_y": 1e9, "shear_modulus": 0.8e9}
COARSE = Fineness(MeshRecipe(spacing=0.07, grading=0.0, growth=2.0), degree=5, tolerance=0.0)


def experiment(angle: float = 0.0, **sheet: object) -> Experiment:
    """Return a hammer and two accelerometers on a plate of spruce."""
    ranges = {"youngs_modulus": (4e9, 10e9), "poisson_ratio": (0.05, 0.3), "loss_factor": (0.005, 0.06)}
    material = {**ranges, "orthotropy": {**TRUE, "angle": angle, **sheet}}
    sensors = [
        {"id": f"acc{k}", "kind": "acceleration", "point": place, "mass": 0.002}
        for k, place in enumerate([(0.38, 0.16), (0.17, 0.07)])
    ]
    return Experiment.model_validate(
        {
            "title": "spruce",
            "plate": {"length_x": 0.4, "length_y": 0.18, "thickness": 0.004, "mass": 0.124, "material": material},
            "drive": [{"id": "hammer", "kind": "force", "point": (0.02, 0.02)}],
            "sensor": sensors,
            "acquisition": {
                "module": "NI-9234",
                "sample_rate": 4266.0,
                "input_resistance": 305e3,
                "input_capacitance": 1.2e-10,
            },
            "protocol": {
                **{"sweep": "linear", "band": BAND, "sweep_duration": 3.0, "tail": 1.0, "repeats": 3},
                **{"ramp_rate": 0.4, "temperatures": (22.0,), "directions": ("up",), "levels": (1.0,)},
            },
            "oven": {"room_temperature": 22.0},
        }
    )


def twin_of(declared: Experiment, near: tuple[float, float, float, float] | None = None) -> Twin:
    material = declared.plate.material
    assert material is not None
    operators = reduce_with_departures(declared, material.box, fineness=COARSE, near=near)
    known = tolerances(declared, operators.movable)
    return replace(Twin.of(declared, EffectPlate(operators), tolerances=known), reach=np.inf)


@pytest.fixture(scope="module")
def declared() -> Experiment:
    """Return a declaration whose moduli are 15 % wrong, and its transverse shear much more."""
    wrong = {"youngs_modulus_x": 1.15, "youngs_modulus_y": 0.85, "shear_modulus": 0.85}
    return experiment(**{name: wrong[name] * value for name, value in TRUE.items()})


@pytest.fixture(scope="module")
def true() -> Twin:
    return twin_of(experiment(transverse_shear_modulus=[0.7e9, 0.08e9]))


def departures() -> dict[str, dict[str, float]]:
    """Return what leads from the wrong declaration to the true one."""
    mean = (12.0 + 1.0) / (12.0 * 1.15 + 0.85)
    return {
        MODULI: {"ratio": float(np.log(1.15 / 0.85)), "shear": float(-np.log(0.85 * mean))},
        TRANSVERSE: {"xz": float(np.log(0.7 / 0.8)), "yz": float(np.log(0.08 / 0.8))},
    }


def test_every_quantity_of_a_turned_sheet_has_its_derivative() -> None:
    twin = twin_of(experiment(angle=25.0))
    here = {name: card.zero() for name, card in twin.tolerance_cards.items() if name in (MODULI, TRANSVERSE, LOSS)}
    assert set(here) == {MODULI, TRANSVERSE, LOSS}
    here |= {MODULI: {"ratio": 0.2, "shear": -0.1}, LOSS: {"ratio": 1.0, "shear": 0.3}}
    tangents = [(name, p, values) for name, values in here.items() for p in values]
    lines = LINES[::10]
    exact = twin.linearise(LAWS, lines, here, POINT, tangents).by_parameter
    for (name, parameter, values), slope in zip(tangents, exact, strict=True):
        step = 1e-4
        sides = [
            twin.frf(LAWS, lines, {**here, name: {**values, parameter: values[parameter] + sign * step}}, POINT)
            for sign in (1, -1)
        ]
        quotient = (sides[0] - sides[1]) / (2.0 * step)
        assert np.abs(slope - quotient).max() < 1e-4 * np.abs(quotient).max(), (name, parameter)


def test_a_departed_sheet_is_the_sheet_of_the_changed_declaration(declared: Experiment, true: Twin) -> None:
    """With vectors about its moduli; moduli are 35 % apart, and transverse shear ten times."""
    away = departures()
    twin = twin_of(declared, (0.3, 0.35, -0.15, -2.3))
    wanted, found = true.frf(LAWS, LINES, {}, POINT), twin.frf(LAWS, LINES, away, POINT)
    for k in range(len(wanted)):
        assert np.linalg.norm(found[k] - wanted[k]) < 2e-3 * np.linalg.norm(wanted[k])
    as_declared = twin.frf(LAWS, LINES, {}, POINT)
    assert np.linalg.norm(as_declared - wanted) > 0.8 * np.linalg.norm(wanted)


def test_a_loss_by_direction_damps_the_modes_of_that_direction(true: Twin) -> None:
    """Bending along the grain has the loss of Ex, torsion that of Gxy; the mean loss is that of the laws."""
    lowest = LINES[LINES < 90.0]  # of this plate: torsion at 79 Hz
    free = {LOSS: {"ratio": 0.0, "shear": 0.0}}
    plain = true.frf(LAWS, lowest, free, POINT)[0]
    double = true.frf(LAWS, lowest, {LOSS: {"ratio": 0.0, "shear": float(np.log(2.0))}}, POINT)[0]
    apart = true.frf(LAWS, lowest, {LOSS: {"ratio": 1.0, "shear": 0.0}}, POINT)[0]
    assert np.abs(plain).max() / np.abs(double).max() == pytest.approx(2.0, rel=0.05)
    assert np.abs(apart).max() == pytest.approx(np.abs(plain).max(), rel=0.05)


def test_moduli_and_losses_are_found_from_a_declaration_far_off(declared: Experiment, true: Twin) -> None:
    """From 15 % wrong moduli resonances are several of their widths off; one output has the wrong sign."""
    losses = {"ratio": 1.0, "shear": 0.4}
    h = np.array([[1.1], [-0.9]]) * true.frf(LAWS, LINES, {LOSS: losses}, POINT)
    rng = np.random.default_rng(4)
    noise = 0.02 * np.sqrt(np.mean(np.abs(h) ** 2, axis=1, keepdims=True)) * np.ones(h.shape)
    h = h + noise * np.sqrt(0.5) * (rng.standard_normal(h.shape) + 1j * rng.standard_normal(h.shape))
    frf = Frf(
        temperature=np.array([22.0]),
        direction=("up",),
        level=np.ones(1),
        frequency=LINES,
        h=h[None],
        variance=noise[None] ** 2,
        coherence=np.ones((1, *h.shape)),
        excluded=np.zeros(LINES.size, bool),
        channels=("acc0", "acc1"),
    )
    found = sheet_start(frf, twin_of(declared), lambda stage, share: None)
    wanted = departures()
    assert found[MODULI]["ratio"] == pytest.approx(wanted[MODULI]["ratio"], abs=0.01)
    # nu and the modulus of shear go together: what the laws call nu is found too
    assert found[MODULI]["shear"] == pytest.approx(wanted[MODULI]["shear"], abs=0.03)
    assert found[TRANSVERSE]["yz"] == pytest.approx(wanted[TRANSVERSE]["yz"], abs=0.2)
    assert found[LOSS] == pytest.approx(losses, abs=0.05)


def test_a_sheet_that_is_exact_has_none_of_these(declared: Experiment) -> None:
    exact = {"moduli": 0.0, "transverse_shear": 0.0, "loss_direction": 0.0}
    known = tolerances(Experiment.model_validate({**declared.model_dump(), "tolerances": exact}), np.zeros(0))
    assert not {MODULI, TRANSVERSE, LOSS} & set(known)
    plain = declared.model_dump()
    plain["plate"] |= {"mass": 0.26, "material": {"kind": "polypropylene"}}
    assert not {MODULI, TRANSVERSE, LOSS} & set(tolerances(Experiment.model_validate(plain), np.zeros(0)))


def test_what_is_fitted_of_a_sheet_in_any_case_is_no_effect(declared: Experiment) -> None:
    """Both at once are counted twice; under one name, as once, the comparison ended in a KeyError."""
    known, effects = tolerances(declared, np.zeros(0)), library(declared)
    assert {MODULI, TRANSVERSE, LOSS} <= set(known)
    assert not {"orthotropy", "loss_orthotropy", "transverse_shear"} & {*effects, *untried(declared)}
    assert not set(known) & set(LIBRARY)
