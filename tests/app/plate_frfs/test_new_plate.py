"""flexura new plate: what the files say stands in plate.toml, what they do not say is left to complete."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.estimation.transfer import MeasuredTransfer
from analysis.recordings.frf import campaign_frf
from analysis.recordings.frf_campaign import FrfCampaign
from app.files.campaigns.export import export_frfs
from app.files.campaigns.loading import load_campaign
from app.files.uff.frfs import write_frfs

Run = Callable[..., tuple[int, str, str]]
LINES = np.arange(50.0, 1000.0, 0.5)
SIZE = ("--plate", 0.3, 0.2, 0.003, 0.48)


def write_uff(path: Path, ends: tuple[str, str] = ("+3", "+3"), hit: str = "-3") -> Path:
    """Accelerances in g/N of two points, hit at a third, with the coordinates of all."""
    h = LINES**2 / (300.0**2 - LINES**2 + 0.01j * 300.0**2)
    frfs = [
        MeasuredTransfer("NONE", f"{node}:{end}", f"7:{hit}", "acceleration", LINES, node * h, units=("g", "N"))
        for node, end in zip((1, 2), ends, strict=True)
    ]
    write_frfs(path, frfs, {1: (0.1, 0.15, 0.0), 2: (0.25, 0.15, 0.0), 7: (0.05, 0.05, 0.0)})
    return path


def test_a_universal_file_with_nodes_leaves_nothing_to_complete(tmp_path: Path, run_flexura: Run) -> None:
    write_uff(tmp_path / "scan_-5.5C.uff")
    status, _, said = run_flexura("new", "plate", tmp_path / "scan_-5.5C.uff", *SIZE)
    assert status == 0
    assert "to be completed" not in said
    read = load_campaign(tmp_path)
    assert isinstance(read, FrfCampaign)
    declared, frf = read.experiment, campaign_frf(read)
    assert declared.drive[0].point == (0.05, 0.05)
    assert [sensor.kind for sensor in declared.sensor] == ["acceleration", "acceleration"]
    assert declared.sensor[1].point == (0.25, 0.15)
    assert frf.temperature.tolist() == [-5.5]
    assert np.abs(frf.h[0, 1]).max() == pytest.approx(9.80665 * 2 * 100.0, rel=1e-3)  # in m/s2/N
    status, _, said = run_flexura("new", "plate", tmp_path / "scan_-5.5C.uff", *SIZE)
    assert status == 2
    assert "is there already" in said


@pytest.mark.parametrize(
    ("ends", "hit", "sides"),
    [
        (("+3", "-3"), "-3", ["top", "bottom"]),
        (("-3", "-3"), "-3", ["bottom", "bottom"]),
        (("+3", "-3"), "+3", ["top", "bottom"]),
        (("-3", "-3"), "+3", ["top", "top"]),
    ],
)
def test_a_response_against_the_others_or_along_the_force_is_out_of_the_bottom_face(
    tmp_path: Path, run_flexura: Run, ends: tuple[str, str], hit: str, sides: list[str]
) -> None:
    """As Flexura's own exports are; with sides on the top face such a channel was called inverted."""
    file = write_uff(tmp_path / "scan_20C.uff", ends, hit)
    assert run_flexura("new", "plate", file, *SIZE)[0] == 0
    assert [sensor.side for sensor in load_campaign(tmp_path).experiment.sensor] == sides


def test_what_files_do_not_say_is_left_as_a_comment(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    campaign = load_campaign(tiny.write(tmp_path / "recorded"))
    export_frfs(tmp_path / "frfs.mat", campaign.experiment, campaign_frf(campaign))
    status, _, said = run_flexura(
        "new", "plate", tmp_path / "frfs.mat", "--frf-units", "V", "V", "--out", tmp_path / "p"
    )
    assert status == 0
    assert "[plate] length_x" in said
    text = (tmp_path / "p" / "plate.toml").read_text(encoding="utf-8")
    for line in (
        "# thickness = 0.003    # m",
        "# input_resistance = 1e6    # ohm across each sensor patch",
        'sensors = { "H_S1[*]" = "S1", "H_S2[*]" = "S2" }',
        'temperature = "temperature"',
        'direction = "descending"',
        "averages = 2.0",
    ):
        assert line in text
    status, _, said = run_flexura("update", tmp_path / "p")
    assert status == 2
    assert "plate.thickness = nothing" in said
    write = re.sub(r"(?m)^# (?=\w+ = )", "", text)
    (tmp_path / "p" / "plate.toml").write_text(write.replace("center = [0.05, 0.05]", "center = [0.1, 0.1]", 1))
    with pytest.raises(ValueError, match="overlap"):
        load_campaign(tmp_path / "p")


def test_many_files_of_one_folder_become_a_pattern(tmp_path: Path, run_flexura: Run) -> None:
    for temperature in (-5.5, 10, 20):
        write_uff(tmp_path / f"scan_{temperature}C.uff")
    status, _, _ = run_flexura("new", "plate", *sorted(tmp_path.glob("*.uff")), *SIZE)
    assert status == 0
    assert 'file = "scan_*C.uff"' in (tmp_path / "plate.toml").read_text(encoding="utf-8")
    assert [one.temperature for one in load_campaign(tmp_path).sweeps] == [-5.5, 10.0, 20.0]


def test_dimensions_that_no_plate_has_are_refused_before_a_file_is_written(
    tmp_path: Path, run_flexura: Run
) -> None:
    file = write_uff(tmp_path / "a.uff")
    status, _, said = run_flexura("new", "plate", file, "--plate", "240", "190", "3", "0.13")
    assert status == 2
    assert (
        "--plate: length_x = 240.0; allowed: a number from 0.01 to 5 (m) (values are SI: 240 thousandths" in said
    )
    assert "thickness = 3.0" in said
    status, _, said = run_flexura("new", "campaign", "--plate", "0.24", "0.19", "0.003", "130", "--out", tmp_path)
    assert status == 2
    assert "density" in said
    assert [path.name for path in tmp_path.iterdir()] == ["a.uff"]


def test_options_of_a_test_are_refused(tmp_path: Path, run_flexura: Run) -> None:
    status, _, said = run_flexura("new", "plate", write_uff(tmp_path / "a.uff"), "--kind", "frf")
    assert status == 2
    assert "of a plate channels are declared in plate.toml" in said
    status, _, said = run_flexura("new", "plate")
    assert status == 2
    assert "flexura new plate FRFS.uff" in said


@pytest.mark.parametrize("sensors", ['{ "1" = "S1", "2" = "S2" }', '{ "1:+z" = "S1", "2:+z" = "S2" }'])
def test_an_array_of_responses_and_references_is_a_hammer_that_moved(
    tmp_path: Path, run_flexura: Run, sensors: str
) -> None:
    """Its numbers are ends of FRFs, as in a modal test; all were declared as sensors of one drive."""
    h = LINES**2 / (300.0**2 - LINES**2 + 0.01j * 300.0**2)
    array = np.array([[[(response + 10 * hit)] * len(LINES) for hit in range(1, 5)] for response in (1, 2)]) * h
    np.savez(tmp_path / "frfs.npz", f=LINES, H=array)
    words = ("--frf-units", "m/s2", "N", "-q")
    assert run_flexura("new", "plate", tmp_path / "frfs.npz", *SIZE, *words)[0] == 0
    text = (tmp_path / "plate.toml").read_text()
    assert 'sensors = { "1" = "S1", "2" = "S2" }' in text
    assert "nodes = [1, 2, 3, 4]" in text
    text = text.replace('{ "1" = "S1", "2" = "S2" }', sensors)
    text = re.sub("# points = .*", "points = [[0.1, 0.1], [0.2, 0.1], [0.1, 0.15], [0.25, 0.15]]", text)
    text = re.sub("# point = .*", "point = [0.05, 0.05]", text, count=1)
    text = re.sub("# point = .*", "point = [0.05, 0.15]", text, count=1)
    (tmp_path / "plate.toml").write_text(re.sub("# temperature = .*", "temperature = 20.0", text))
    read = load_campaign(tmp_path)
    assert isinstance(read, FrfCampaign)
    assert len(read.sweeps) == 2
    for sweep in read.sweeps:
        factors = [11, 21, 31, 41] if sweep.source == 0 else [12, 22, 32, 42]
        np.testing.assert_allclose(np.abs(sweep.h[:, 0] / sweep.h[0, 0]), np.array(factors) / factors[0])


def test_of_several_shakers_each_sensor_has_an_frf_of_each(tmp_path: Path, run_flexura: Run) -> None:
    h = LINES**2 / (300.0**2 - LINES**2 + 0.01j * 300.0**2)
    np.savez(tmp_path / "frfs.npz", f=LINES, H=np.arange(1, 7).reshape(3, 2, 1) * h)
    assert run_flexura("new", "plate", tmp_path / "frfs.npz", *SIZE, "--frf-units", "m/s2", "N", "-q")[0] == 0
    text = (tmp_path / "plate.toml").read_text()
    assert 'sensors = { "1" = "S1", "2" = "S2", "3" = "S3" }' in text
    assert 'drives = { "1" = "D1", "2" = "D2" }' in text
