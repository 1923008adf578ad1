"""A hammer that moves between points: ends exchanged by reciprocity, one gain for all hits."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.estimation.transfer import MeasuredTransfer
from analysis.material import LocalLaws, MaterialBox
from analysis.recordings.frf_campaign import FrfCampaign
from analysis.recordings.sweep_point import SweepPoint
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.loading import load_campaign
from app.files.declarations.plate import read_plate_measurement
from app.files.uff.frfs import read_frfs, write_frfs
from app.plate_frfs.given_campaign import declared_experiment
from simulation.effects.library import library
from simulation.reduction.effect_reduction import reduce_with_effects
from simulation.shell.fineness import Fineness
from simulation.state.plate_state import unweighed
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

Run = Callable[..., tuple[int, str, str]]

LINES = np.arange(50.0, 300.0, 0.5)
POINTS = [[0.03, 0.02], [0.15, 0.02], [0.27, 0.11], [0.1, 0.18]]
NODES = [11, 12, 7, 30]
PLATE = """
format = "flexura-plate/1"
title = "aluminium plate, roving hammer"

[plate]
length_x = 0.3
length_y = 0.2
thickness = 0.003
mass = 0.486
material = { kind = "aluminium" }
"""
ACCELEROMETERS = """
[[sensor]]
id = "acc1"
kind = "acceleration"
point = [0.04, 0.03]
mass = 0.0006

[[sensor]]
id = "acc2"
kind = "acceleration"
point = [0.2, 0.16]
side = "bottom"
"""
FRF = '[[frf]]\nfile = "frfs.uff"\nsensors = { "901" = "acc1", "902:+z" = "acc2" }\ntemperature = 21.0\n'


def hammer(points: object = POINTS, nodes: object = NODES) -> str:
    return f'\n[[drive]]\nid = "hammer"\npoints = {points}\nnodes = {nodes}\n'


def of_two_accelerometers(folder: Path, text: str, rows: NDArray[np.complex128]) -> Path:
    """Write FRFs (2, M, F) of accelerometers at nodes 901 and 902, hit by hit, and the declaration."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "plate.toml").write_text(text, encoding="utf-8")
    units = ("m/s2", "N")
    frfs = [
        MeasuredTransfer(
            f"hit {hit}", f"{at}:+3", f"{node}:-3", "acceleration", LINES, rows[k, hit], "force", units
        )
        for hit, node in enumerate(NODES)
        for k, at in enumerate((901, 902))
    ]
    write_frfs(folder / "frfs.uff", frfs)
    return folder


@pytest.fixture
def rows() -> NDArray[np.complex128]:
    rng = np.random.default_rng(1)
    resonance = 1.0 / (120.0**2 - LINES**2 + 0.02j * 120.0**2)
    return np.asarray(rng.uniform(1.0, 9.0, (2, 4, 1)) * resonance)


def test_accelerometers_drive_and_the_points_of_the_hammer_answer(
    tmp_path: Path, rows: NDArray[np.complex128]
) -> None:
    read = load_campaign(of_two_accelerometers(tmp_path, PLATE + hammer() + ACCELEROMETERS + FRF, rows))
    assert isinstance(read, FrfCampaign)
    experiment = read.experiment
    assert [one.id for one in experiment.inputs] == ["acc1", "acc2"]
    assert [one.id for one in experiment.outputs] == ["hammer1", "hammer2", "hammer3", "hammer4"]
    assert {one.quantity for one in experiment.outputs} == {"acceleration"}
    feet = [one.footprint for one in (*experiment.inputs, *experiment.outputs) if one.footprint]
    assert [foot.point for foot in feet[:2]] == [(0.04, 0.03), (0.2, 0.16)]
    assert [list(foot.point) for foot in feet[2:]] == POINTS
    assert [foot.mass for foot in feet] == [0.0006, 0.0, 0.0, 0.0, 0.0, 0.0]
    assert unweighed(experiment).tolist() == [False, True, False, False, False, False]  # a candidate for `gap`
    # of a force into the top at acc1 and into the bottom at acc2, as the motions out of these faces were
    assert [foot.along for foot in feet] == [-1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    for sweep in read.sweeps:
        np.testing.assert_allclose(sweep.h, rows[sweep.source], rtol=1e-9)
    assert sorted(sweep.source for sweep in read.sweeps) == [0, 1]
    assert experiment.tolerances.sensitivity == 0.0
    assert any("4 points with one gain" in note for note in read.notes)


def test_points_are_numbered_as_declared_unless_nodes_say_otherwise(
    tmp_path: Path, rows: NDArray[np.complex128]
) -> None:
    text = PLATE + re.sub(r"nodes = .*\n", "", hammer()) + ACCELEROMETERS + FRF
    numbers = 'drives = { "11" = "hammer2", "12" = "hammer1", "7" = "hammer3", "30" = "hammer4" }\n'
    read = load_campaign(of_two_accelerometers(tmp_path, text + numbers, rows))
    assert isinstance(read, FrfCampaign)
    np.testing.assert_allclose(read.sweeps[0].h, rows[read.sweeps[0].source][[1, 0, 2, 3]], rtol=1e-9)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (hammer(nodes=[1, 2]) + ACCELEROMETERS, "'hammer': nodes must be 4 different numbers"),
        (hammer(nodes=[1, 2, 2, 3]) + ACCELEROMETERS, "'hammer': nodes must be 4 different numbers"),
        (
            hammer() + ACCELEROMETERS.replace("acceleration", "velocity", 1).replace("mass", "# mass"),
            "of one kind",
        ),
        (hammer() + '\n[[drive]]\nid = "shaker"\npoint = [0.1, 0.1]\n' + ACCELEROMETERS, "is the only drive"),
        (hammer() + ACCELEROMETERS.replace("point = [0.04, 0.03]", "grid = [2, 2]"), "a single point each"),
        (hammer([*POINTS, [0.2, 0.1]], [*NODES, 31]) + ACCELEROMETERS, "no FRF of 'hammer5'"),
        (hammer([[0.3, 0.5], *POINTS[1:]]) + ACCELEROMETERS, "off the plate"),
    ],
)
def test_what_does_not_fit_is_said(text: str, said: str, tmp_path: Path, rows: NDArray[np.complex128]) -> None:
    folder = of_two_accelerometers(tmp_path, PLATE + text + FRF, rows)
    with pytest.raises(CampaignFileError, match=re.escape(said)):
        load_campaign(folder)


def test_hits_elsewhere_are_left_out_with_a_note(tmp_path: Path, rows: NDArray[np.complex128]) -> None:
    text = PLATE + hammer(POINTS[:3], NODES[:3]) + ACCELEROMETERS + FRF
    read = load_campaign(of_two_accelerometers(tmp_path, text, rows))
    assert len(read.experiment.outputs) == 3
    assert any("not declared, left out" in note for note in read.notes)


def test_which_accelerometer_is_asked_for(tmp_path: Path, rows: NDArray[np.complex128]) -> None:
    text = PLATE + hammer() + ACCELEROMETERS + re.sub("sensors.*\n", "", FRF)
    folder = of_two_accelerometers(tmp_path, text, rows)
    with pytest.raises(CampaignFileError, match=r"which accelerometer is which FRF\? .* \"901"):
        load_campaign(folder)


E_TRUE, NU_TRUE, ETA_TRUE = 69.3e9, 0.334, 0.004
HIDDEN, PLACE = 0.005, (0.21, 0.06)
ONE_ACCELEROMETER = ACCELEROMETERS.partition('\n[[sensor]]\nid = "acc2"')[0]
GRID = [[x, y] for y in (0.014, 0.057, 0.1, 0.143, 0.186) for x in (0.012, 0.081, 0.15, 0.219, 0.288)]
TOLERANCES = "\n[tolerances]\nthickness = 0.0\nmass = 0.0\nlength = 0.0\n"


def simulated(folder: Path, mass: float, hit: list[list[float]] = GRID) -> Path:
    """Five hits at each of 25 points, noise of 1 % each, on a plate of another mesh and degree than the twin's.

    `hit` are the places that were hit, where these are not the declared ones.
    """
    declared, text = (
        PLATE + hammer(points, list(range(1, 26))) + ONE_ACCELEROMETER + TOLERANCES for points in (GRID, hit)
    )
    frf = FRF.replace(', "902:+z" = "acc2"', "") + "averages = 5\n"
    folder.mkdir()
    file = folder / "plate.toml"
    file.write_text(f"{text}\n[[cable]]\npoint = [{PLACE[0]}, {PLACE[1]}]\n{frf}", encoding="utf-8")
    lines, band = np.arange(60.0, 600.0, 0.5), (60.0, 599.5)
    said, rest = read_plate_measurement(file)
    experiment = declared_experiment(file, said, rest, band)
    box = MaterialBox((60e9, 78e9), (0.30, 0.36), (0.002, 0.008))
    usual = Fineness().recipe(experiment.plate, box, band)
    finer = Fineness(replace(usual, spacing=0.6 * usual.spacing), degree=6)
    plate = EffectPlate(reduce_with_effects(experiment, box, fineness=finer)[0])
    laws = LocalLaws(21.0, np.array([np.log(E_TRUE), NU_TRUE, np.log(ETA_TRUE)]), np.zeros(3), np.zeros(3))
    twin = Twin.of(experiment, plate, library(experiment), {})
    h = twin.frf(laws, lines, {"point_mass": {"mass": mass}} if mass else {}, SweepPoint(21.0, 0.0, 1.0))
    rng = np.random.default_rng(2)
    noise = rng.standard_normal(h.shape) + 1j * rng.standard_normal(h.shape)
    h = h + 0.01 / np.sqrt(2 * 5) * np.sqrt((np.abs(h) ** 2).mean(axis=1, keepdims=True)) * noise
    units = ("m/s2", "N")
    write_frfs(
        folder / "frfs.uff",
        [
            MeasuredTransfer(f"hit {node}", "901:+3", f"{node}:-3", "acceleration", lines, row, "force", units)
            for node, row in enumerate(h, start=1)
        ],
    )
    file.write_text(declared + frf, encoding="utf-8")
    return folder


@pytest.mark.slow
def test_a_roving_hammer_gives_the_material(tmp_path: Path, run_flexura: Run) -> None:
    folder = simulated(tmp_path / "bare", 0.0)
    status, out, said = run_flexura("update", folder, "--json")
    assert status == 0, said
    assert json.loads(out)["pairing"]["points"]["said"] == []
    (row,) = json.loads(out)["temperatures"]
    assert row["youngs_modulus_pa"] == pytest.approx(E_TRUE, rel=1e-3)
    assert row["poisson_ratio"] == pytest.approx(NU_TRUE, abs=5e-4)
    assert row["loss_factor"] == pytest.approx(ETA_TRUE, rel=0.01)
    assert json.loads(out)["gain"] == pytest.approx(1.0, abs=0.01)
    # hits at points 3 and 4 written down the wrong way round, and one at point 7 from below
    other = {"3": "4", "4": "3"}
    frfs = [
        replace(
            one,
            reference=f"{other.get(one.reference.partition(':')[0], one.reference.partition(':')[0])}:-3",
            h=-one.h if one.reference.startswith("7:") else one.h,
        )
        for one in read_frfs(folder / "frfs.uff")
    ]
    write_frfs(folder / "frfs.uff", frfs)
    _, out, said = run_flexura("update", folder, "--json")
    exchanged, sign = json.loads(out)["pairing"]["points"]["said"]
    assert exchanged.startswith("points hammer3 and hammer4 are exchanged")
    assert sign.startswith("point hammer7 moves like its mirror: sign")
    assert exchanged in said


@pytest.mark.slow
def test_the_place_of_a_wrong_node_is_offered(tmp_path: Path, run_flexura: Run) -> None:
    """Point 13 was hit 8 cm from its place, in the middle of four others."""
    there = [0.19, 0.165]
    folder = simulated(tmp_path / "wrong", 0.0, [*GRID[:12], there, *GRID[13:]])
    status, out, said = run_flexura("update", folder, "--json")
    assert status in (0, 1), said
    (sentence,) = json.loads(out)["pairing"]["points"]["said"]
    found = re.match(
        r"point hammer13 does not move as the twin there .* at \(([\d.]+), ([\d.]+)\) m, ([\d.]+) m away", sentence
    )
    assert found is not None, sentence
    assert [float(found[1]), float(found[2])] == pytest.approx(there, abs=0.008)
    assert float(found[3]) == pytest.approx(np.hypot(there[0] - GRID[12][0], there[1] - GRID[12][1]), abs=0.01)
    assert sentence in said


@pytest.mark.slow
def test_a_hidden_mass_is_named_and_located(tmp_path: Path, run_flexura: Run) -> None:
    status, out, said = run_flexura("gap", simulated(tmp_path / "loaded", HIDDEN), "--json")
    assert status == 0, said
    (effect,) = json.loads(out)["effects"]
    found = {name: one["value"] for name, one in effect["parameters"].items()}
    assert effect["name"] == "mass_at_place"
    assert found["mass"] == pytest.approx(HIDDEN, rel=0.01)
    assert np.hypot(found["x"] - PLACE[0], found["y"] - PLACE[1]) < 0.01


def test_new_plate_writes_one_hammer_for_all_points(
    tmp_path: Path, rows: NDArray[np.complex128], run_flexura: Run
) -> None:
    folder = of_two_accelerometers(tmp_path / "frfs", "", rows)
    table = tmp_path / "points.csv"
    where = {901: (0.04, 0.03), 902: (0.2, 0.16), **dict(zip(NODES, POINTS, strict=True))}
    table.write_text("".join(f"{node},{x},{y},0.0\n" for node, (x, y) in where.items()), encoding="utf-8")
    sizes = ("--plate", "0.3", "0.2", "0.003", "0.486", "--points", table)
    status, _, said = run_flexura("new", "plate", folder / "frfs.uff", *sizes, "--out", tmp_path / "made")
    assert status == 0, said
    file = tmp_path / "made" / "plate.toml"
    text = re.sub("# temperature = 20.0", "temperature = 20.0", file.read_text(encoding="utf-8"))
    assert text.count("[[drive]]") == 1
    file.write_text(
        text.replace("mass = 0.486", 'mass = 0.486\nmaterial = { kind = "aluminium" }'), encoding="utf-8"
    )
    read = load_campaign(tmp_path / "made")
    assert isinstance(read, FrfCampaign)
    feet = [one.footprint for one in read.experiment.outputs if one.footprint]
    assert [list(foot.point) for foot in feet] == POINTS
    for sweep in read.sweeps:
        np.testing.assert_allclose(sweep.h, rows[sweep.source], rtol=1e-9)
