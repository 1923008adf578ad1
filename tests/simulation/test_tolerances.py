"""Tolerances of the twin: derivatives, and the twin of the plate whose declaration is changed."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.declaration.tolerances import Tolerances
from analysis.experiment import Experiment
from analysis.material import LocalLaws, MaterialBox
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import HeldEffects
from simulation.effects import point_mass, thermal_lag, transverse_shear
from simulation.reduction.effect_reduction import reduce_with_departures
from simulation.shell.fineness import Fineness
from simulation.shell.piezo_material import NCE51, PIEZO_MATERIALS, VACUUM_PERMITTIVITY
from simulation.state.plate_state import Departures
from simulation.tolerances import tolerances
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

BAND = (100.0, 500.0)
LINES = np.linspace(*BAND, 120)
POINT = SweepPoint(26.0, 0.0, 1.0)
BOX = MaterialBox((1e9, 3.2e9), (0.33, 0.46), (0.02, 0.12))
LAWS = LocalLaws(25.0, np.array([np.log(2e9), 0.38, np.log(0.06)]), np.array([-0.02, 0.002, -0.01]), np.zeros(3))


@pytest.fixture(scope="module")
def made():
    """Make the twin of an experiment, with tolerances."""

    def make(experiment, fineness=None):
        operators = reduce_with_departures(experiment, BOX, fineness=fineness)
        plate, known = EffectPlate(operators), tolerances(experiment, operators.movable)
        return replace(Twin.of(experiment, plate, tolerances=known), reach=np.inf)

    return make


@pytest.fixture(scope="module")
def patched(declare, patches):
    """Two patches, one of them open, a hammer, an accelerometer and a laser."""
    dumped = declare(patches, BAND).model_dump()
    return Experiment.model_validate(
        dumped
        | {
            "patch": [dumped["patch"][0], dumped["patch"][1]],
            "sensor": [
                {"id": "acc", "kind": "acceleration", "point": (0.17, 0.12), "mass": 0.003},
                {"id": "laser", "kind": "velocity", "point": (0.1, 0.15)},
            ],
        }
    )


@pytest.fixture(scope="module")
def coarse(made, patched, coarse_mesh):
    return made(patched, Fineness(coarse_mesh, degree=4, tolerance=0.0))


@pytest.fixture(scope="module")
def twin(made, patched):
    return made(patched)


def zeros(twin):
    return {name: card.zero() for name, card in twin.tolerance_cards.items()}


def test_as_declared_nothing_changes(coarse):
    exact = replace(coarse, tolerances={})
    assert np.allclose(
        coarse.frf(LAWS, LINES, zeros(coarse), POINT), exact.frf(LAWS, LINES, point=POINT), rtol=1e-9
    )


def displaced(twin):
    """Return the tolerances' values with both patches moved by two standard deviations, and made smaller."""
    here = zeros(twin)
    for name, share in (("patch_place A1", 2.0), ("patch_place S1", -2.0), ("patch_size S1", -2.0)):
        here[name] = {p.name: share * p.sigma for p in twin.tolerance_cards[name].parameters}
    return here


def test_the_laws_derivatives_contain_what_moved_patches_change(coarse):
    """Without it they were several per cent wrong, and fits did not settle."""
    here, step = displaced(coarse), 1e-4
    line = coarse.linearise(LAWS, LINES, here, POINT)
    plain = coarse.linearise(LAWS, LINES, zeros(coarse), POINT)
    for law in range(3):
        value = LAWS.value + step * np.eye(3)[law]
        ahead = coarse.frf(replace(LAWS, value=value), LINES, here, POINT)
        behind = coarse.frf(replace(LAWS, value=2.0 * LAWS.value - value), LINES, here, POINT)
        quotient = (ahead - behind) / (2.0 * step)
        off = np.linalg.norm(line.by_material[law] - quotient) / np.linalg.norm(quotient)
        assert off < 8e-3
        assert np.linalg.norm(plain.by_material[law] - quotient) > 4.0 * off * np.linalg.norm(quotient)


@pytest.mark.parametrize("place", [zeros, displaced])
def test_every_quantity_has_its_derivative(coarse, place):
    twin = coarse
    here = place(twin)
    tangents = [(name, p.name, here[name]) for name, card in twin.tolerance_cards.items() for p in card.parameters]
    line = twin.linearise(LAWS, LINES, here, POINT, tangents)
    cards = [p for card in twin.tolerance_cards.values() for p in card.parameters]
    seen = {name for name, _, _ in tangents}
    assert {"plate_thickness", "patch_place A1", "transducer_place acc", "transducer_mass acc"} <= seen
    for (name, parameter, _), card, exact in zip(tangents, cards, line.by_parameter, strict=True):
        step = 0.02 * card.sigma
        sides = [
            twin.frf(
                LAWS, LINES, {**here, name: {**here[name], parameter: here[name][parameter] + sign * step}}, POINT
            )
            for sign in (1, -1)
        ]
        quotient = (sides[0] - sides[1]) / (2.0 * step)
        if name.startswith("attachment_place"):  # felt where an effect acts there
            assert not exact.any()
            continue
        assert np.abs(exact).max() > 0.0, name
        near = 1e-3
        assert np.abs(exact - quotient).max() < near * np.abs(quotient).max(), (name, parameter)


def test_shear_across_the_plate_is_what_its_effect_changes(coarse):
    """The effect is named where this tolerance is exceeded: both are the same change of the plate."""
    known = replace(coarse, library={"transverse_shear": transverse_shear.EFFECT})
    here = {**zeros(coarse), "plate_shear": {"share": float(np.log(1.1))}}
    wanted = known.frf(LAWS, LINES, {**zeros(coarse), "transverse_shear": {"delta": 0.1}}, POINT)
    np.testing.assert_allclose(coarse.frf(LAWS, LINES, here, POINT), wanted, rtol=1e-9)
    assert not np.allclose(wanted, coarse.frf(LAWS, LINES, zeros(coarse), POINT), rtol=1e-4)
    assert known.cards["transverse_shear"].replaces == "plate_shear"
    assert not HeldEffects.around(known).cards
    released = HeldEffects.around(known).releasing(["plate_shear"])
    assert "transverse_shear" in released.cards
    assert "plate_shear" not in released.tolerance_cards


def on_ramps(patched, directions=("up",), reading="air", rate=0.4):
    """Return the plate whose sweeps are made on ramps of so many K/min."""
    table = patched.model_dump()
    protocol = table["protocol"] | {"directions": directions, "ramp_rate": rate}
    return Experiment.model_validate(table | {"protocol": protocol, "oven": table["oven"] | {"reading": reading}})


@pytest.mark.parametrize(
    ("ramps", "free"),
    [
        ({}, True),
        ({"directions": ("down",)}, True),
        ({"directions": ("up", "down")}, False),  # there it is found, as an effect
        ({"reading": "plate"}, False),
        ({"rate": 0.0}, False),
    ],
)
def test_the_plate_may_lag_where_nothing_recorded_tells(patched, ramps, free):
    known = tolerances(on_ramps(patched, **ramps), np.ones(2))
    assert ("plate_lag" in known) == free


def test_a_plate_that_lags_is_what_its_effect_changes(made, patched, coarse_mesh):
    """On one ramp all laws were shifted by 1 K, and their sigma contained 0.3 K."""
    twin = made(on_ramps(patched), Fineness(coarse_mesh, degree=4, tolerance=0.0))
    twin = replace(twin, library={"thermal_lag": thermal_lag.EFFECT})
    point, name = replace(POINT, rate=0.4 / 60.0), "plate_lag"
    here = {**zeros(twin), name: {"behind": 300.0}}
    wanted = twin.frf(LAWS, LINES, {**zeros(twin), "thermal_lag": {"tau": 300.0}}, point)
    np.testing.assert_allclose(twin.frf(LAWS, LINES, here, point), wanted, rtol=1e-9)
    line = twin.linearise(LAWS, LINES, zeros(twin), point, [(name, "behind", zeros(twin)[name])])
    np.testing.assert_allclose(line.by_parameter[0], -point.rate * line.by_temperature, rtol=1e-9)
    assert not np.allclose(wanted, twin.frf(LAWS, LINES, zeros(twin), point), rtol=1e-3)


def test_the_place_of_an_attachment_matters_where_a_load_acts(made, patched, coarse_mesh):
    """A mass that is moved changes the response as its place does."""
    fineness = Fineness(coarse_mesh, degree=4, tolerance=0.0)
    plain = made(patched, fineness)
    heavy = replace(plain, library={"point_mass": point_mass.EFFECT})
    effects, name = {"point_mass": {"mass": 1e-3}}, "attachment_place cable 1"
    here = {**zeros(plain), **effects}
    line = heavy.linearise(LAWS, LINES, here, POINT, [(name, "dx", here[name])])
    x, y = patched.cable[0].point
    sides = []
    for step in (2e-4, -2e-4):
        cable = ({"point": (x + step, y)},)
        moved = Experiment.model_validate({**patched.model_dump(), "cable": cable})
        there = replace(made(moved, fineness), library={"point_mass": point_mass.EFFECT})
        sides.append(there.frf(LAWS, LINES, effects, POINT))
    quotient = (sides[0] - sides[1]) / 4e-4
    assert np.linalg.norm(line.by_parameter[0] - quotient) < 0.05 * np.linalg.norm(quotient)


def scanned(patched, move=0.0):
    """Return the plate with a laser that scans 15 points, all of them moved along x."""
    table = patched.model_dump()
    points = [(0.03 + 0.04 * i + move, 0.03 + 0.06 * j) for j in range(3) for i in range(5)]
    scan = {"id": "scan", "kind": "velocity", "points": points}
    return Experiment.model_validate({**table, "sensor": [scan]})


@pytest.mark.parametrize("scan", [True, False])
def test_points_of_a_scan_are_where_they_were_measured_however_long_the_plate_is(patched, scan):
    """They moved with the plate's length: 0.3 mm left 3.5 times the noise of 1 %, as if an effect were missing."""
    experiment = scanned(patched) if scan else patched
    known, length, longer = tolerances(experiment, np.zeros(2)), patched.plate.length_x, 1e-3
    away = known["plate_length_x"].changed(Departures(), {"longer": longer})
    points = np.array([one.footprint.point[0] for one in experiment.outputs if one.footprint])
    moved = points * away["stretch_x"] + np.broadcast_to(away.get("place_x", 0.0), len(points)) - points
    np.testing.assert_allclose(moved, 0.0 if scan else points * longer / length, atol=3e-3 * longer)
    # each of a few transducers has a place of its own to be wrong; a scan lies somewhere
    assert ("scan_place" in known, "transducer_place acc" in known) == (scan, not scan)


def test_a_scan_lies_somewhere_on_the_plate(made, patched, coarse_mesh):
    fineness = Fineness(coarse_mesh, degree=4, tolerance=0.0)
    here = made(scanned(patched), fineness)
    there = zeros(here)
    there["scan_place"] = {"dx": 3e-4, "dy": 0.0}
    before = here.frf(LAWS, LINES, zeros(here), POINT)
    wanted = made(scanned(patched, move=3e-4), fineness).frf(LAWS, LINES, point=POINT) - before
    left = here.frf(LAWS, LINES, there, POINT) - before - wanted
    assert np.linalg.norm(left[-15:]) < 0.1 * np.linalg.norm(wanted[-15:])


OPEN = 0.1  # an open patch changes other responses by 1e-3 of themselves
CHANGES = [
    ("plate_thickness", {"share": 0.01}, {"plate": {"thickness": 0.003 * 1.01}}, 0.02),
    ("plate_mass", {"share": 0.01}, {"plate": {"mass": 1.01}}, 0.02),
    ("plate_length_x", {"longer": 1e-3}, {"plate": {"length_x": 1e-3}}, 0.08),
    ("patch_place A1", {"dx": -5e-4, "dy": 3e-4}, {"place": (0, -5e-4, 3e-4)}, 0.03),
    ("patch_place S1", {"dx": 1e-4, "dy": 2e-4}, {"place": (1, 1e-4, 2e-4)}, OPEN),
    ("patch_size S1", {"along": 4e-4, "across": 4e-4}, {"size": (1, 4e-4, 4e-4)}, OPEN),
    ("patch_size S1", {"along": 3e-4, "across": -3e-4}, {"size": (1, 3e-4, -3e-4)}, OPEN),
    ("patch_size A1", {"along": 3e-4, "across": 0.0}, {"size": (0, 3e-4, 0.0)}, 0.05),
    ("patch_thickness A1", {"share": 0.01}, {"thicker": (0, float(np.exp(0.01)))}, 0.02),
    ("patch_thickness S1", {"share": 0.01}, {"thicker": (1, float(np.exp(0.01)))}, OPEN),
    ("patch_modulus A1", {"share": 0.08}, {"stiffer": 0}, 0.02),
    ("input_resistance", {"share": float(np.log(1.1))}, {"inputs": 1.1}, 0.01),
    ("transducer_mass acc", {"heavier": 2e-4}, {"mass": 2e-4}, 0.01),
    ("transducer_place acc", {"dx": 3e-4, "dy": -2e-4}, {"at": (3e-4, -2e-4)}, 0.03),
    ("transducer_contact acc", {"larger": 0.5625 - 1.0}, {"radius": 0.003}, 0.05),
    ("transducer_contact acc", {"larger": -1.0}, {"radius": 0.0}, 0.1),
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "values", "change", "left"), CHANGES, ids=[row[0] for row in CHANGES])
def test_it_is_the_twin_of_the_changed_declaration(made, patched, twin, name, values, change, left, monkeypatch):
    """Its change of the transfer is that of a twin made anew, up to a share `left` and both twins' own errors."""
    monkeypatch.setitem(PIEZO_MATERIALS, "PZT-5A", stiffer(NCE51, float(np.exp(0.08))))
    before, there = twin.frf(LAWS, LINES, zeros(twin), POINT), zeros(twin)
    there[name] = {**there[name], **values}
    if name.startswith("plate_length"):  # patches and transducers keep their places from the corner
        for place, at in {"patch_place A1": 0, "patch_place S1": 1}.items():
            there[place] = {**there[place], "dx": -patched.patch[at].center[0] * 1e-3 / patched.plate.length_x}
        for place in patched.sensor:
            moved = {"dx": -place.point[0] * 1e-3 / patched.plate.length_x}
            there[f"transducer_place {place.id}"] = {**there[f"transducer_place {place.id}"], **moved}
    wanted = made(changed(patched, change)).frf(LAWS, LINES, point=POINT) - before
    found = twin.frf(LAWS, LINES, there, POINT) - before
    for k in range(len(wanted)):
        own = 2.0 * twin.error * np.linalg.norm(before[k])
        assert np.linalg.norm(found[k] - wanted[k]) < left * np.linalg.norm(wanted[k]) + own


def stiffer(material, factor):
    """Return a ceramic with other moduli and the same d31, density and clamped permittivity."""
    softer = replace(material, compliance=material.compliance / factor)
    free = material.relative_permittivity + (material.permittivity - softer.permittivity) / VACUUM_PERMITTIVITY
    return replace(softer, relative_permittivity=free)


def changed(experiment, change):
    """Return an experiment declared otherwise."""
    table = experiment.model_dump()
    table["plate"] |= {
        "thickness": change.get("plate", {}).get("thickness", table["plate"]["thickness"]),
        "mass": table["plate"]["mass"] * change.get("plate", {}).get("mass", 1.0),
        "length_x": table["plate"]["length_x"] + change.get("plate", {}).get("length_x", 0.0),
    }
    patch = [dict(one) for one in table["patch"]]
    if "place" in change:
        k, dx, dy = change["place"]
        patch[k]["center"] = (patch[k]["center"][0] + dx, patch[k]["center"][1] + dy)
    if "size" in change:
        k, *larger = change["size"]
        patch[k]["size"] = tuple(side + more for side, more in zip(patch[k]["size"], larger, strict=True))
    if "thicker" in change:
        k, factor = change["thicker"]
        patch[k]["thickness"] *= factor
    if "stiffer" in change:
        patch[change["stiffer"]]["material"] = "PZT-5A"
    table["acquisition"]["input_resistance"] *= change.get("inputs", 1.0)
    sensor = [dict(one) for one in table["sensor"]]
    sensor[0]["mass"] += change.get("mass", 0.0)
    if "radius" in change:
        sensor[0]["radius"] = change["radius"]
    dx, dy = change.get("at", (0.0, 0.0))
    sensor[0]["point"] = (sensor[0]["point"][0] + dx, sensor[0]["point"][1] + dy)
    return Experiment.model_validate({**table, "patch": patch, "sensor": sensor})


MOVED = {"dx": 5e-4, "dy": -3e-4}


def about_moved(patched, fineness=None):
    """Return a twin of the declared plate, made about one where a patch has moved, and that one's declaration."""
    about = changed(patched, {"place": (0, MOVED["dx"], MOVED["dy"])})
    operators = reduce_with_departures(about, BOX, fineness=fineness)
    known = tolerances(patched, operators.movable, {"patch_place A1": MOVED})
    return replace(Twin.of(patched, EffectPlate(operators), tolerances=known), reach=np.inf), about


def test_a_twin_made_about_moved_patches_is_exact_there(made, patched, coarse_mesh):
    fineness = Fineness(coarse_mesh, degree=4, tolerance=0.0)
    twin, about = about_moved(patched, fineness)
    assert {p.name: p.made_at for p in twin.tolerance_cards["patch_place A1"].parameters} == MOVED
    moved = made(about, fineness)
    wanted = moved.frf(LAWS, LINES, zeros(moved), POINT)
    found = twin.frf(LAWS, LINES, {**zeros(twin), "patch_place A1": MOVED}, POINT)
    np.testing.assert_allclose(found, wanted, rtol=1e-9)


@pytest.mark.slow
def test_where_patches_were_declared_it_is_as_good_as_the_declared_one_elsewhere(made, patched, twin):
    moved, about = about_moved(patched)
    before = twin.frf(LAWS, LINES, zeros(twin), POINT)
    change = np.linalg.norm(made(about).frf(LAWS, LINES, point=POINT) - before)
    for known_as in (zeros(moved), {}):  # a quantity without a value is as declared
        assert np.linalg.norm(moved.frf(LAWS, LINES, known_as, POINT) - before) < 0.06 * change


def test_what_is_exact_is_no_parameter(patched):
    exact = Tolerances(
        **dict.fromkeys(Tolerances.model_fields.keys() - {"own"}, 0.0), own={"plate.thickness": 6e-5}
    )
    known = tolerances(patched.model_copy(update={"tolerances": exact}), np.ones(2))
    (card,) = [one.card(patched) for one in known.values()]
    assert (card.name, card.parameters[0].sigma) == ("plate_thickness", 6e-5 / patched.plate.thickness)


def test_the_points_of_one_sensor_have_one_sensitivity(patched):
    """A laser's grid is measured by one laser; alone its sensitivity is the gain."""
    dumped = patched.model_dump(exclude_none=True)
    laser = {"id": "laser", "kind": "velocity", "grid": (20, 10)}
    several = Experiment.model_validate(dumped | {"sensor": [dumped["sensor"][0], laser]})
    names = [name for name in tolerances(several, np.zeros(2)) if name.startswith("sensitivity")]
    assert names == ["sensitivity acc", "sensitivity laser"]
    alone = Experiment.model_validate(dumped | {"sensor": [laser], "patch": [dumped["patch"][0]]})
    assert not [name for name in tolerances(alone, np.zeros(1)) if name.startswith("sensitivity")]


def test_patches_without_room_have_no_place_to_be_wrong(patched):
    known = tolerances(patched, np.array([0.0, 1.0]))
    assert "patch_place S1" in known
    assert not {"patch_place A1", "patch_size A1"} & set(known)
