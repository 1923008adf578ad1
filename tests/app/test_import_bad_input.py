"""Every way a recording can be wrong: named with file, key and value, exit status 2, nothing left behind."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

Run = Callable[..., tuple[int, str, str]]


def refused(run_flexura: Run, folder: Path, *options: str) -> str:
    """Import `folder`, expect a refusal that leaves nothing but a picture, and return what it said."""
    before = sorted(folder.parent.rglob("*"))
    status, output, message = run_flexura("import", folder, *options)
    assert status == 2, message
    assert output == ""
    assert "Traceback" not in message
    left = set(folder.parent.rglob("*")) - set(before)
    assert left == ({folder.parent / f"{folder.name}-geometry.png"} if "picture: " in message else set())
    return message


DECLARATION = [
    (
        "thickness = 0.003\n",
        "thickness = 3.0\n",
        r"plate\.thickness = 3\.0; allowed: .*0\.0001 to 0\.05 \(m\).*0\.003",
    ),
    ("mass = 0.13", "mass = 130.0", r"plate: mass 130 kg.*density.*20 to 25000"),
    ("mass = 0.13\n", "", r"plate\.mass = nothing; allowed: .*kg.*missing"),
    (
        "length_x = 0.24",
        'length_x = "0.24"',
        r"plate\.length_x = '0\.24'; allowed: a number from 0\.01 to 5 \(m\)",
    ),
    ("length_x = 0.24", "length_x = true", r"plate\.length_x = True; allowed: a number"),
    ("length_x = 0.24", "lenght_x = 0.24", r"plate\.lenght_x = unknown key.*did you mean length_x"),
    ("repeats = 2", "repeats = 2.5", r"protocol\.repeats = 2\.5; allowed: an integer from 1 to 1000"),
    ("repeats = 2", "repeats = 0", r"protocol\.repeats = 0; allowed: an integer from 1"),
    ("10.0, 20.0, 30.0]", "10.0, 30.0, 20.0]", r"protocol: temperatures must ascend: 20 follows 30"),
    ("10.0, 20.0, 30.0]", "283.0, 293.0, 303.0]", r"protocol\.temperatures\[0\] = 283\.0; .*Celsius"),
    ("10.0, 20.0, 30.0]", "10.0, nan, 30.0]", r"protocol\.temperatures\[1\] = nan; allowed: a number"),
    ("10.0, 20.0, 30.0]", "]", r"protocol\.temperatures = \[\]; allowed: a list of numbers, at least 1"),
    (
        'directions = ["up", "down"]',
        'directions = ["sideways"]',
        r"directions\[0\] = 'sideways'; .*'up' or 'down'",
    ),
    ("levels = [1.0]", "levels = [-1.0]", r"protocol\.levels\[0\] = -1\.0; allowed: a number above 0"),
    ("band = [100.0, 1500.0]", "band = [1500.0, 100.0]", r"protocol: band \[1500\.0, 100\.0\] Hz"),
    ("band = [100.0, 1500.0]", "band = [0.1, 1.5]", r"protocol: band \[0\.1, 1\.5\] Hz holds 0 .* 1 kHz is 1000"),
    ("band = [100.0, 1500.0]", "band = 1500.0", r"protocol\.band = 1500\.0; allowed: a list of 2 numbers \(Hz\)"),
    ("8533.333333333334", "8500.0", r"acquisition\.sample_rate = 8500; .*nearest is 8533\.33\d* Hz \(n = 6\)"),
    ("8533.333333333334", "8.533", r"acquisition\.sample_rate = 8\.533; allowed: a number from 100 .*Hz"),
    ("input_resistance = 305000.0\n", "", r"acquisition\.input_resistance = nothing; .*ohm"),
    (
        "recorded-campaign/1",
        "recorded-campaign/9",
        r"format = 'recorded-campaign/9'; allowed: 'recorded-campaign/1'",
    ),
    ('"NCE51"', '"PZT-8"', r"patch\[0\]\.material = 'PZT-8'; allowed: 'NCE51' or 'PIC255' or 'PZT-5A'"),
    ('role = "sensor"', 'role = "actuator"', r"actuator = nothing; allowed: .*which one drove"),
    ("center = [0.04, 0.035]", "center = [40, 35]", r"patch 'S1' spans 39\.99 to 40\.01 m along x.*0 to 0\.24"),
    ('id = "S2"', 'id = "S1"', r"patch id 'S1' is used 2 times"),
    ('id = "S2"', 'id = "drive"', "patch 'drive' has the name of the drive's channel"),
    ("[oven]\nroom_temperature = 22.0\n", "", r"oven = nothing; allowed: a table with the keys room_temperature"),
    ("[acquisition]", "[acquisition", r"line 4\d = '\[acquisition'; allowed: TOML"),
    (
        "temperatures = [10.0, 20.0, 30.0]",
        f"temperatures = {list(range(-80, 201))}",
        r"missing = \d+ of the protocol",
    ),
    (
        "levels = [1.0]",
        f"levels = {[1 + n / 1e4 for n in range(9999)]}",
        r"protocol: .* is 59994 sweeps; allowed 1 to",
    ),
]


@pytest.mark.parametrize(("old", "new", "said"), DECLARATION)
def test_declaration(tiny: Any, tmp_path: Path, run_flexura: Run, old: str, new: str, said: str) -> None:
    assert old in tiny.toml
    tiny.toml = tiny.toml.replace(old, new, 1)
    message = refused(run_flexura, tiny.write(tmp_path / "plate"))
    assert re.search(said, message), message
    assert "campaign.toml" in message or "sweeps/" in message


def test_a_wrong_geometry_is_told_with_its_place_and_drawn(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    hole = '\n[[plate.hole]]\nkind = "circle"\ncenter = [0.05, 0.035]\nradius = 0.02\n\n[[patch]]\n'
    tiny.toml = tiny.toml.replace("\n[[patch]]\n", hole, 1)
    message = refused(run_flexura, tiny.write(tmp_path / "plate"))
    assert re.search(r"patch 'S1' reaches into hole 1 at \(0\.0\d+, 0\.0\d+\) m; move it", message), message
    assert f"picture: {tmp_path / 'plate-geometry.png'}" in message


def test_faults_of_a_declaration_are_told_together(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    tiny.toml = tiny.toml.replace("repeats = 2", "repeats = 0").replace("length_y = 0.19\n", "")
    message = refused(run_flexura, tiny.write(tmp_path / "plate"))
    assert "2 problems" in message
    assert "plate.length_y" in message
    assert "protocol.repeats" in message


def test_declaration_in_another_encoding(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    folder = tiny.write(tmp_path / "plate")
    (folder / "campaign.toml").write_bytes(tiny.toml.replace("tiny", "ä").encode("latin-1"))
    assert re.search(r"campaign\.toml: byte \d+ is not UTF-8", refused(run_flexura, folder))


def test_declaration_of_absurd_size(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    tiny.toml += "#" * 1_000_001
    assert "bytes; allowed: at most 1000000" in refused(run_flexura, tiny.write(tmp_path / "plate"))


Break = Callable[[Any], object]


def begun_later(file: Any) -> None:
    """Let a channel begin a millisecond after the drive of its group."""
    start = np.datetime64("2026-01-05T10:00:00", "us")
    at("repeat 1/drive", wf_start_time=start)(file)
    at("repeat 1/S1", wf_start_time=start + np.timedelta64(1, "ms"))(file)


def at(place: str, **properties: object) -> Break:
    """Set (or with None remove) properties of a channel, "repeat 1/S1", or of the root, ""."""

    def change(file: Any) -> None:
        here = file.properties
        if place:
            group, channel = place.split("/")
            here = file.channel_properties[group][channel]
        for key, value in properties.items():
            if value is None:
                del here[key]
            else:
                here[key] = value

    return change


def samples(place: str, change: Callable[[Any], Any]) -> Break:
    """Replace the samples of a channel."""

    def replace(file: Any) -> None:
        group, channel = place.split("/")
        file.groups[group][channel] = change(file.groups[group][channel].copy()).astype(np.float32)

    return replace


def put(index: int, value: float) -> Callable[[Any], Any]:
    def change(values: Any) -> Any:
        values[index] = value
        return values

    return change


def rename(old: str, new: str) -> Break:
    def change(file: Any) -> None:
        for group in file.groups:
            file.groups[group] = {new if c == old else c: s for c, s in file.groups[group].items()}
            given = file.channel_properties[group]
            file.channel_properties[group] = {new if c == old else c: p for c, p in given.items()}

    return change


def every(change: Callable[[Any], Any]) -> Break:
    """Replace the samples of every channel."""

    def replace(file: Any) -> None:
        for group in file.groups:
            file.groups[group] = {c: change(s) for c, s in file.groups[group].items()}
            for channel, values in file.groups[group].items():
                file.channel_properties[group][channel]["wf_samples"] = len(values)

    return replace


RECORDING: list[tuple[str, Break, str]] = [
    ("wrong channel name", rename("S1", "ai0"), r"channels of repeat 1 = drive, ai0, S2; allowed: drive, S1, S2"),
    ("extra channel", lambda f: f.groups["repeat 1"].update(S9=f.groups["repeat 1"]["S1"])
        or f.channel_properties["repeat 1"].update(S9=f.channel_properties["repeat 1"]["S1"]),
        r"channels of repeat 1 = drive, S1, S2, S9; allowed: .*not expected: S9"),
    ("lost channel", lambda f: f.groups["repeat 2"].pop("drive"), r"of repeat 2 = S1, S2;.*missing: drive"),
    ("lost repeat", lambda f: f.groups.pop("repeat 2"), r"groups = repeat 1; allowed: repeat 1, repeat 2"),
    ("unequal", samples("repeat 1/S2", lambda v: v[:-3]), r"samples = unequal: .*S2 1533.*; allowed: 1536 in"),
    ("too short", every(lambda v: v[:1000]), r"samples = 1000 in every channel; allowed: 1536, .*sweep_duration"),
    ("zero length", every(lambda v: v[:0]), r"samples = 0: zero-length sweeps; allowed: 1536"),
    ("nan", samples("repeat 2/S1", put(517, np.nan)), r"repeat 2/S1 = nan at sample 517 \(1 of 1536\); .*finite"),
    ("inf", samples("repeat 1/drive", put(3, np.inf)), r"repeat 1/drive = inf at sample 3 \(1 of 1536\)"),
    ("clipped at 5 V", samples("repeat 1/S1", lambda v: np.clip(60 * v, -5, 5)),
        r"repeat 1/S1 = \d+ clipped samples, up to 5 V; allowed: below the 5 V that the NI-9234"),
    ("clipped below", samples("repeat 1/S1", lambda v: np.clip(v, -0.05, 0.05)),
        r"repeat 1/S1 = \d+ clipped samples, flat at -0\.05 or 0\.05 V"),
    ("silent", samples("repeat 2/S2", lambda v: 0 * v), r"repeat 2/S2 = 0 to 0 V throughout; allowed: a signal"),
    ("drive in mV", samples("repeat 1/drive", lambda v: 4.0 * v), r"peak of drive = 4 V; allowed: 1 V within 10%"),
    ("other rate", at("repeat 1/S1", wf_increment=1e-4), r"repeat 1/S1 wf_increment = 0\.0001; .*0\.0001171875 s"),
    ("skewed", at("repeat 1/S1", wf_start_offset=1e-3), r"repeat 1/S1 wf_start_offset = 0\.001; allowed: 0\.0 s"),
    ("begun later", begun_later,
        r"repeat 1/S1 wf_start_time \+ wf_start_offset = 8\.533 samples .* later; allowed: the start"),
    ("counts", at("repeat 1/S1", **{"NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Reciprocal"}),
        r"npTDMS says: Unsupported scale type: Reciprocal"),
    ("no offset", at("repeat 1/S1", wf_start_offset=None), r"repeat 1/S1 wf_start_offset = None; allowed: a time"),
    ("miscounted", at("repeat 1/S1", wf_samples=12), r"repeat 1/S1 wf_samples = 12; allowed: 1536"),
    ("mV", at("repeat 2/S2", unit_string="mV"), r"repeat 2/S2 unit_string = 'mV'; allowed: 'V'"),
    ("no unit", at("repeat 2/S2", unit_string=None), r"repeat 2/S2 unit_string = nothing; allowed: 'V'"),
    ("text for a number", at("", level="1.0"), r"level = '1\.0'; allowed: a number above 0"),
    ("no step", at("", step=None), r"step = nothing; allowed: an integer from 0"),
    ("half a step", at("", step=2.5), r"step = 2\.5; allowed: an integer from 0"),
    ("negative step", at("", step=-1), r"step = -1; allowed: an integer from 0"),
    ("same step", at("", step=1), r"step = 1; allowed: a number of its own; .*001\.tdms has this one"),
    ("no direction", at("", direction="over"), r"direction = 'over'; allowed: 'up' or 'down'"),
    ("no time", at("", start_time="yesterday"), r"start_time = 'yesterday'; allowed: an ISO 8601 time"),
    ("no temperature", at("", oven_temperature_end=None), r"oven_temperature_end = nothing; allowed: -80 to 200"),
    ("kelvin", at("", oven_temperature_start=303.15, oven_temperature_end=303.15),
        r"oven_temperature_start = 303\.15; allowed: -80 to 200 \(degrees Celsius\)"),
    ("nan temperature", at("", oven_temperature_start=float("nan")), r"oven_temperature_start = nan"),
    ("off the grid", at("", oven_temperature_start=25.1, oven_temperature_end=25.1),
        r"oven_temperature_start, _end = 25\.1 to 25\.1 °C; allowed: near one of .*30 °C is the nearest"),
    ("runaway oven", at("", oven_temperature_start=28.0, oven_temperature_end=32.0),
        r"oven_temperature_end = 32 °C, 4 K from oven_temperature_start"),
    ("other level", at("", level=0.5) , r"level = 0\.5 V; allowed: protocol\.levels \[1\.0\]|peak of drive = 1 V"),
    ("twice", at("", oven_temperature_start=20.0, oven_temperature_end=20.0),
        r"sweep = 20 °C up 1 V; allowed: one file for it; sweeps/001\.tdms is another"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "said"), [case[1:] for case in RECORDING], ids=[case[0] for case in RECORDING])
def test_recording(tiny: Any, tmp_path: Path, run_flexura: Run, change: Break, said: str) -> None:
    change(tiny.files["002.tdms"])
    message = refused(run_flexura, tiny.write(tmp_path / "plate"))
    assert "sweeps/002.tdms: " in message
    assert re.search(said, message), message


def test_levels_unknown_to_the_protocol(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    tiny.toml = tiny.toml.replace("levels = [1.0]", "levels = [2.0]")
    message = refused(run_flexura, tiny.write(tmp_path / "plate"))
    assert "level = 1 V; allowed: protocol.levels [2.0]" in message


def test_directions_unknown_to_the_protocol(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    tiny.toml = tiny.toml.replace('["up", "down"]', '["up"]')
    message = refused(run_flexura, tiny.write(tmp_path / "plate"))
    assert "sweeps/003.tdms and 2 more files: direction = 'down'; allowed: protocol.directions ['up']" in message


def test_temperatures_out_of_order(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    tiny.files["001.tdms"].properties["step"], tiny.files["002.tdms"].properties["step"] = 2, 1
    message = refused(run_flexura, tiny.write(tmp_path / "plate"))
    assert "sweeps/001.tdms: temperature of step 2 = 20 °C; allowed: above the 30 °C of the step before" in message


def test_missing_temperature_is_named(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    del tiny.files["001.tdms"]
    message = refused(run_flexura, tiny.write(tmp_path / "plate"))
    assert "missing = 1 of the protocol's sweeps: 20 °C up 1 V" in message
    assert "--allow-missing" in message


def test_everything_wrong_is_told_at_once(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    samples("repeat 1/S1", put(5, np.nan))(tiny.files["000.tdms"])
    rename("S2", "ai2")(tiny.files["003.tdms"])
    folder = tiny.write(tmp_path / "plate")
    (folder / "sweeps" / "005.tdms").write_bytes(b"")
    message = refused(run_flexura, folder)
    assert "4 problems" in message  # the wrong name is told of both repeats
    for name in ("000", "003", "005"):
        assert f"sweeps/{name}.tdms: " in message
    assert "missing = " not in message  # damaged files are there: nothing is lost


@pytest.mark.parametrize("share", [0.0, 1e-4, 0.003, 0.02, 0.3, 0.7, 0.999])
def test_truncated_anywhere(tiny: Any, tmp_path: Path, run_flexura: Run, share: float) -> None:
    folder = tiny.write(tmp_path / "plate")
    path = folder / "sweeps" / "004.tdms"
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    said = "an empty file|not a TDMS file|truncated after|groups = |channels of|unequal"
    assert re.search(rf"sweeps/004\.tdms: ({said})", refused(run_flexura, folder))


def test_random_damage_is_refused_or_harmless(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    """Whatever the header's bytes say, the answer is a message; a file that still reads is a campaign."""
    folder = tiny.write(tmp_path / "plate")
    path = folder / "sweeps" / "004.tdms"
    whole = path.read_bytes()
    rng = np.random.default_rng(5)
    for _ in range(60):
        damaged = bytearray(whole)
        for position in rng.integers(0, 1500, 3):
            damaged[position] = int(rng.integers(0, 256))
        path.write_bytes(damaged)
        status, _, message = run_flexura("import", folder, "--out", tmp_path / "out" / str(rng.integers(1 << 30)))
        assert status in (0, 2)
        assert status == 0 or "sweeps/004.tdms: " in message


def test_other_file_in_the_place_of_a_tdms(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    folder = tiny.write(tmp_path / "plate")
    (folder / "sweeps" / "004.tdms").write_text("time,drive,S1\n0,0,0\n" * 20)
    assert "sweeps/004.tdms: not a TDMS file; allowed: NI TDMS" in refused(run_flexura, folder)


def test_file_of_absurd_size_is_not_read(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    folder = tiny.write(tmp_path / "plate")
    with (folder / "sweeps" / "004.tdms").open("ab") as file:
        file.truncate(10**11)  # sparse: it takes no room
    assert re.search(r"004\.tdms: 100000000000 bytes; allowed: at most \d+", refused(run_flexura, folder))


def test_stale_index_beside_a_file_is_not_believed(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    folder = tiny.write(tmp_path / "plate")
    (folder / "sweeps" / "004.tdms_index").write_bytes(b"TDSh" + bytes(100))
    assert run_flexura("import", folder)[0] == 0


@pytest.mark.parametrize("there", ["nothing", "a file", "an empty folder", "other things"])
def test_folder_that_is_no_campaign(tmp_path: Path, run_flexura: Run, there: str) -> None:
    folder = tmp_path / "plate"
    if there == "a file":
        folder.write_text("x")
    elif there != "nothing":
        folder.mkdir()
    if there == "other things":
        (folder / "notes.txt").write_text("x")
    said = {
        "nothing": "does not exist",
        "a file": "a file, not a campaign",
        "an empty folder": "it holds nothing",
        "other things": "it holds notes.txt",
    }[there]
    message = refused(run_flexura, folder)
    assert said in message
    assert "campaign.toml" in message


@pytest.mark.parametrize("there", [False, True])
def test_campaign_without_sweeps(tiny: Any, tmp_path: Path, run_flexura: Run, there: bool) -> None:
    folder = tmp_path / "plate"
    folder.mkdir()
    (folder / "campaign.toml").write_text(tiny.toml)
    if there:
        (folder / "sweeps").mkdir()
    assert f"sweeps/: {'no TDMS file' if there else 'no such folder'}" in refused(run_flexura, folder)


def test_a_sensor_of_another_name_is_one_line(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    tiny.toml = tiny.toml.replace('id = "S2"', 'id = "S7"')
    message = refused(run_flexura, tiny.write(tmp_path / "plate"))
    assert message.count("\n") == 1
    assert (
        "sweeps/000.tdms and 5 more files: channels of repeat 1 = drive, S1, S2; allowed: drive, S1, S7" in message
    )
    assert message.endswith("(also in 1 more repeat)\n")


@pytest.mark.parametrize("verb", ["import", "update", "identify"])
def test_an_experiment_is_sent_to_acquire(run_flexura: Run, verb: str) -> None:
    file = Path(__file__).resolve().parents[2] / "examples" / "simulated-rig.toml"
    status, _, message = run_flexura(verb, file)
    assert status == 2
    assert f"an experiment, not yet a campaign; flexura acquire {file} makes one of it" in message


def test_a_declaration_is_sent_to_its_folder(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    folder = tiny.write(tmp_path / "plate")
    status, _, message = run_flexura("import", folder / "campaign.toml")
    assert status == 2
    assert message.endswith(f"declares a recorded campaign; name its folder: {folder}\n")
