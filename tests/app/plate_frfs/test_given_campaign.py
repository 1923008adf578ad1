"""FRFs of other programs reach the twin through plate.toml: read back as exported, or refused in words."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.io import netcdf_file

from analysis.recordings.frf import Frf, campaign_frf
from analysis.recordings.frf_campaign import FrfCampaign
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.export import averages, export_frfs, stated_coherence
from app.files.campaigns.loading import load_campaign

Run = Callable[..., tuple[int, str, str]]

FRFS = {
    "uff": 'file = "frfs.uff"\naverages = 2\n',
    "mat": (
        'file = "frfs.mat"\ntemperature = "temperature"\nlevel = "level"\ndirection = "descending"\naverages = 2\n'
        'sensors = { "H_S1[*]" = "S1", "H_S2[*]" = "S2" }\nunits = ["V", "V"]\n'
        'coherence = { S1 = "coherence_S1[*]", S2 = "coherence_S2[*]" }\n'
    ),
    "csv": 'file = "frfs_*.csv"\naverages = 2\n',
    "nc": (
        'file = "frfs.nc"\ntemperature = "temperature"\nlevel = "level"\ndirection = "descending"\naverages = 2\n'
        'sensors = { "h[*,1]" = "S1", "h[*,2]" = "S2" }\nunits = ["V", "V"]\n'
        'coherence = { S1 = "coherence[*,1]", S2 = "coherence[*,2]" }\n'
    ),
}


def declared(toml: str, frf: str) -> str:
    """Turn a recorded campaign's declaration into that of a plate."""
    return toml.replace("recorded-campaign/1", "flexura-plate/1") + "\n[[frf]]\n" + frf


def write_plate(folder: Path, text: str) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "plate.toml").write_text(text, encoding="utf-8")
    return folder


@pytest.fixture
def exported(tiny: Any, tmp_path: Path) -> tuple[Any, Frf, Path]:
    """Make a campaign of time signals, its FRFs, and the folder in which it is exported in all formats."""
    campaign = load_campaign(tiny.write(tmp_path / "recorded"))
    frf = campaign_frf(campaign)
    folder = tmp_path / "frfs"
    folder.mkdir()
    for ending in FRFS:
        export_frfs(folder / f"frfs.{ending}", campaign.experiment, frf)
    return campaign, frf, folder


@pytest.mark.parametrize("form", FRFS)
def test_exports_are_read_back(form: str, exported: tuple[Any, Frf, Path], tiny: Any) -> None:
    _, frf, folder = exported
    read = load_campaign(write_plate(folder, declared(tiny.toml, FRFS[form])))
    assert isinstance(read, FrfCampaign)
    again = campaign_frf(read)
    # downward sweeps are put in the order of falling temperature, as they were recorded
    assert again.direction == frf.direction
    assert again.channels == frf.channels
    np.testing.assert_allclose(again.temperature, frf.temperature, atol=0.006)  # names carry two decimals
    np.testing.assert_allclose(again.frequency, frf.frequency, rtol=1e-9)
    np.testing.assert_allclose(again.h, frf.h, rtol=1e-9)
    # smoothed over frequency once more: the same level, and the same course but where it bends
    np.testing.assert_allclose(np.median(again.variance / frf.variance, axis=-1), 1.0, atol=0.03)
    assert again.repeats_dof is not None
    assert again.repeats_dof.tolist() == [2] * 6
    assert "plate.toml" in read.hashes
    assert all(re.fullmatch("[0-9a-f]{64}", digest) for digest in read.hashes.values())


def test_the_coherence_exported_is_that_of_the_variance(exported: tuple[Any, Frf, Path]) -> None:
    """Bendat and Piersol, Random Data, 2010, ch. 9: v = |h|^2 (1 - c) / ((n - 1) c)."""
    _, frf, _ = exported
    c, n = stated_coherence(frf, 0), averages(frf, 0)
    assert n == 2
    np.testing.assert_allclose(np.abs(frf.h[0]) ** 2 * (1.0 - c) / ((n - 1) * c), frf.variance[0], rtol=1e-6)


def test_netcdf_holds_the_frfs_over_temperature(exported: tuple[Any, Frf, Path], tmp_path: Path) -> None:
    """Read by SciPy's reader, as xarray does it: temperature is a coordinate of the sweeps."""
    campaign, frf, _ = exported
    export_frfs(tmp_path / "frfs.nc", campaign.experiment, frf)
    with netcdf_file(tmp_path / "frfs.nc", mmap=False) as file:
        held = {name: np.array(one[:]) for name, one in file.variables.items()}
        assert file.variables["h_real"].dimensions == ("sweep", "sensor", "frequency")
        assert b"temperature" in file.variables["h_real"].coordinates
    np.testing.assert_array_equal(held["temperature"], frf.temperature)
    np.testing.assert_array_equal(held["h_real"] + 1j * held["h_imag"], frf.h)
    np.testing.assert_array_equal(held["variance"], frf.variance)
    assert [b"".join(row).decode().strip() for row in held["sensor_name"]] == list(frf.channels)


def test_own_frf_h5_is_read_with_its_noise(
    exported: tuple[Any, Frf, Path], tmp_path: Path, run_flexura: Run
) -> None:
    _, frf, _ = exported
    status, _, said = run_flexura(
        "identify", tmp_path / "recorded", "--method", "peak-picking", "--out", tmp_path / "run"
    )
    assert status == 0, said
    status, _, said = run_flexura("update", tmp_path / "run")
    assert status == 2
    assert f"flexura new plate {tmp_path / 'run' / 'frf.h5'}" in said
    status, _, said = run_flexura("new", "plate", tmp_path / "run" / "frf.h5", "--out", tmp_path / "again")
    assert status == 0, said
    again = campaign_frf(load_campaign(tmp_path / "again"))
    np.testing.assert_array_equal(again.h, frf.h)
    np.testing.assert_array_equal(again.variance, frf.variance)


@pytest.mark.parametrize("name", ["measured.h5", "measured.hdf5"])
def test_hdf5_of_another_program_is_read_by_its_structure(
    name: str, exported: tuple[Any, Frf, Path], tiny: Any, tmp_path: Path, run_flexura: Run
) -> None:
    """It has the ending of our own results, which carry a digest."""
    _, frf, _ = exported
    (tmp_path / "plate").mkdir()
    with h5py.File(tmp_path / "plate" / name, "w") as file:
        file["frequency"], file["frequency"].attrs["units"] = frf.frequency, "Hz"
        file["temperature"], file["level"] = frf.temperature, frf.level
        file["descending"] = np.array([one == "down" for one in frf.direction], dtype=float)
        for place, one in enumerate(frf.channels):
            file[f"H_{one}"], file[f"coherence_{one}"] = frf.h[:, place], frf.coherence[:, place]
    said = f'file = "{name}"\n' + FRFS["mat"].partition("\n")[2]
    again = campaign_frf(load_campaign(write_plate(tmp_path / "plate", declared(tiny.toml, said))))
    np.testing.assert_allclose(again.temperature, frf.temperature, atol=0.006)
    np.testing.assert_allclose(again.h, frf.h, rtol=1e-9)
    words = ("new", "plate", tmp_path / "plate" / name, "--out", tmp_path / "again")
    status, _, err = run_flexura(*words)
    assert status == 0, err
    assert name in (tmp_path / "again" / "plate.toml").read_text("utf-8")


def of_npz(folder: Path, toml: str, frf: str, **arrays: NDArray[Any]) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(folder / "frfs.npz", **arrays)
    return write_plate(folder, declared(toml, frf))


def resonance(frequency: NDArray[np.float64], pole: float) -> NDArray[np.complex128]:
    return np.asarray(pole**2 / (pole**2 - frequency**2 + 0.02j * pole**2))


LINES = np.arange(100.0, 1000.0, 0.5)


def test_noise_that_no_file_gives_is_taken_from_neighbouring_lines(tiny: Any, tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    noise = 1e-3 * (rng.standard_normal((2, LINES.size)) + 1j * rng.standard_normal((2, LINES.size)))
    h = resonance(LINES, 500.0) + noise
    toml = re.sub(r"\[protocol\].*?(?=\n\[)", "", tiny.toml, flags=re.DOTALL)
    frf = 'file = "frfs.npz"\ntemperature = 21.5\nsensors = { "h[1]" = "S1", "h[2]" = "S2" }\n'
    read = load_campaign(of_npz(tmp_path / "plate", toml, frf, frequency=LINES, h=h))
    assert isinstance(read, FrfCampaign)
    found = campaign_frf(read)
    np.testing.assert_allclose(np.median(found.variance[0], axis=-1), 2e-6, rtol=0.15)
    assert any("S1, S2: the files give no noise" in note for note in found.notes)
    assert any("no units in it; V and V are taken" in note for note in found.notes)
    assert read.experiment.protocol.temperatures == (21.5,)
    assert read.experiment.protocol.ramp_rate == 0.0
    assert read.experiment.acquisition.module == "not stated"
    assert read.experiment.oven.room_temperature == (21.5 if "[oven]" not in toml else 22.0)


@pytest.mark.parametrize(
    ("frf", "message"),
    [
        ('file = "none_*.uff"\n', "frf[0].file = 'none_*.uff'; allowed: a pattern of files (there are"),
        ('file = "frfs.npz"\n', "no temperature, neither in its name nor in that of FRF 'h[1]'"),
        ('file = "frfs.npz"\ntemperature = 400.0\n', "temperature"),
        ('file = "frfs.npz"\ntemperature = "T"\n', "temperature = 'T', but the file has no such array; it holds:"),
        ('file = "frfs.npz"\ntemperature = 20.0\n', "which sensor is FRF 'h[1]'"),
        ('file = "frfs.npz"\ntemperature = 20.0\nsensors = { "h[1]" = "S9" }\n', "frf.sensors names 'S9'"),
        ('file = "frfs.npz"\ntemperature = 20.0\nsensors = { "h[1]" = "S1" }\n', "no FRF of 'S2'"),
        ('file = "frfs.npz"\ntemperature = 20.0\nsensors = { "g[1]" = "S1" }\n', "no FRF 'g[1]'; it holds: f"),
        (
            'file = "frfs.npz"\npattern = "{temp}C"\n',
            "pattern = '{temp}C': {temp}; allowed, once each: temperature",
        ),
        (
            'file = "frfs.npz"\ntemperature = 20.0\nunits = ["m/s2", "V"]\n'
            'sensors = { "h[1]" = "S1", "h[2]" = "S2" }\n',
            "is of acceleration at the sensor 'S1', which is declared with voltage",
        ),
        ('file = "frfs.npz"\ntemperatur = 20.0\n', "did you mean temperature?"),
    ],
)
def test_what_is_wrong_is_said(frf: str, message: str, tiny: Any, tmp_path: Path) -> None:
    h = np.array([resonance(LINES, 500.0), resonance(LINES, 400.0)])
    toml = re.sub(r"\[protocol\].*?(?=\n\[)", "", tiny.toml, flags=re.DOTALL)
    folder = of_npz(tmp_path / "plate", toml, frf, frequency=LINES, h=h)
    if "sensors" not in frf and "temperature = 20" not in frf and "npz" in frf:
        frf += 'sensors = { "h[1]" = "S1", "h[2]" = "S2" }\n'
        write_plate(folder, declared(toml, frf))
    with pytest.raises(ValueError, match=re.escape(message)):
        load_campaign(folder)


def test_lines_that_do_not_agree_are_refused(tiny: Any, tmp_path: Path) -> None:
    toml = re.sub(r"\[protocol\].*?(?=\n\[)", "", tiny.toml, flags=re.DOTALL)
    frf = 'file = "f_*.npz"\nsensors = { "h[1]" = "S1", "h[2]" = "S2" }\n'
    folder = write_plate(tmp_path / "plate", declared(toml, frf))
    for temperature, lines in ((20, LINES), (30, LINES + 0.2)):
        h = np.array([resonance(lines, 500.0), resonance(lines, 400.0)])
        np.savez(folder / f"f_{temperature}C.npz", frequency=lines, h=h)
    with pytest.raises(CampaignFileError, match=re.escape("all FRFs of a plate share their lines")):
        load_campaign(folder)


def test_the_dead_ends_name_the_way(exported: tuple[Any, Frf, Path], tmp_path: Path, run_flexura: Run) -> None:
    *_, folder = exported
    alone = tmp_path / "mat"
    alone.mkdir()
    (folder / "frfs.mat").rename(alone / "frfs.mat")
    for verb in ("update", "gap"):
        for target in (folder / "frfs.uff", alone / "frfs.mat", alone):
            status, _, said = run_flexura(verb, target)
            assert status == 2
            assert "flexura new plate" in said
    write_plate(folder, declared("", FRFS["csv"]))
    status, _, said = run_flexura("import", folder, "--out", tmp_path / "imported")
    assert status == 2
    assert f"flexura update {folder} takes it as it is" in said


@pytest.mark.parametrize(
    ("name", "temperature"),
    [("scan_-5.5C.npz", -5.5), ("scan-20C.npz", 20.0), ("plate 20,5 °C.npz", 20.5), ("x_21degC_up.npz", 21.0)],
)
def test_a_temperature_in_a_name(name: str, temperature: float, tiny: Any, tmp_path: Path) -> None:
    toml = re.sub(r"\[protocol\].*?(?=\n\[)", "", tiny.toml, flags=re.DOTALL)
    folder = write_plate(
        tmp_path / "plate", declared(toml, 'file = "*.npz"\nsensors = { "h[1]" = "S1", "h[2]" = "S2" }\n')
    )
    h = np.array([resonance(LINES, 500.0), resonance(LINES, 400.0)])
    np.savez(folder / name, frequency=LINES, h=h)
    read = load_campaign(folder)
    assert read.sweeps[0].temperature == temperature


HAMMER = """
format = "flexura-test/1"
kind = "hammer"
temperature = 22.0

[channels]
"time" = { role = "time" }
"force" = { role = "drive", unit = "N" }
"a1" = { role = "response", unit = "m/s2" }

[[record]]
file = "hits.csv"
"""
STRUCK = """
format = "flexura-plate/1"
title = "struck"

[plate]
length_x = 0.3
length_y = 0.2
thickness = 0.003
mass = 0.48
material = { kind = "aluminium" }

[[drive]]
id = "hammer"
point = [0.05, 0.05]

[[sensor]]
id = "a1"
kind = "acceleration"
point = [0.1, 0.15]

[[frf]]
file = "test.toml"
"""


def test_time_signals_of_a_hammer_reach_the_plate_with_their_noise(tmp_path: Path) -> None:
    """Five blows on one mode at 200 Hz; the noise of the response gives the FRF's variance at every line."""
    rate, blocks, length = 2000.0, 5, 4000
    rng, time = np.random.default_rng(2), np.arange(length) / rate
    force = np.zeros(blocks * length)
    for blow in range(blocks):
        force[blow * length + 200 :][:6] = [20.0, 80.0, 120.0, 80.0, 20.0, 5.0]
    ringing = np.exp(-0.02 * 2 * np.pi * 200.0 * time) * np.sin(2 * np.pi * 200.0 * time)
    answer = np.convolve(force, ringing)[: len(force)] + 0.5 * rng.normal(size=len(force))
    columns = np.column_stack([np.arange(len(force)) / rate, force, answer])
    text = "time [s],force [N],a1 [m/s2]\n" + "\n".join(",".join(f"{x:.8g}" for x in row) for row in columns)
    folder = write_plate(tmp_path / "plate", STRUCK)
    (folder / "hits.csv").write_text(text, encoding="utf-8")
    (folder / "test.toml").write_text(HAMMER, encoding="utf-8")
    read = load_campaign(folder)
    frf = campaign_frf(read)
    assert frf.temperature.tolist() == [22.0]
    assert set(read.hashes) == {"plate.toml", "test.toml", "hits.csv"}
    assert read.sweeps[0].noise == ("coherence",)
    peak = frf.frequency[np.argmax(np.abs(frf.h[0, 0]))]
    assert peak == pytest.approx(200.0, abs=1.0)
    used = ~frf.excluded
    true = np.exp(-2j * np.pi * frf.frequency[used, None] * time) @ ringing
    ratio = np.abs(frf.h[0, 0, used] - true) ** 2 / frf.variance[0, 0, used]
    assert 0.7 < ratio.mean() < 1.4


def test_a_run_takes_a_plate_with_frfs_as_it_is(
    exported: tuple[Any, Frf, Path], tiny: Any, run_flexura: Run
) -> None:
    folder = write_plate(exported[2], declared(tiny.toml, FRFS["uff"]))
    words = ["run", folder, "--until", "identify", "--set", "identify.method=peak-picking"]
    status, _, message = run_flexura(*words)
    assert status in (0, 1), message
    assert (folder.parent / "frfs-run" / "modes.h5").is_file()
    assert not (folder.parent / "frfs-campaign").exists()
    assert "identify: up to date" in run_flexura(*words)[2]
    with (folder / "frfs.uff").open("ab") as file:
        file.write(b"\n")
    assert "identify: up to date" not in run_flexura(*words)[2]


def test_a_copy_is_no_repeat(exported: Any, tiny: Any) -> None:
    """A file copied into the folder counted as a second measurement: deviations were too small by sqrt(2)."""
    folder = exported[2]
    text = declared(tiny.toml, FRFS["csv"])
    wanted = load_campaign(write_plate(folder / "..", text.replace("frfs_*", "frfs/frfs_*")))
    first = sorted(folder.glob("frfs_*.csv"))[0]
    (folder / f"{first.stem} (copy).csv").write_bytes(first.read_bytes())
    read = load_campaign(folder / "..")
    assert isinstance(read, FrfCampaign)
    assert len(read.sweeps) == len(wanted.sweeps)
    assert any("(copy).csv" in note and "is left out: a copy of" in note for note in read.notes)


def test_the_same_numbers_at_two_temperatures_are_told(exported: Any, tiny: Any) -> None:
    folder = exported[2]
    first = sorted(folder.glob("frfs_*.csv"))[0]
    other = re.sub(r"[0-9.]+C", "71.5C", first.name)
    assert other != first.name
    (folder / other).write_bytes(first.read_bytes())
    read = load_campaign(
        write_plate(folder / "..", declared(tiny.toml, FRFS["csv"].replace("frfs_*", "frfs/frfs_*")))
    )
    assert any("holds the same numbers for S1 at 71.5" in note for note in read.notes)
