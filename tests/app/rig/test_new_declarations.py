"""Experiments and panels that ``flexura new`` writes are read, and have the devices of the computer in them."""

from collections.abc import Callable
from pathlib import Path

import pytest

from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError
from app.files.declarations.experiment import read_acquired_experiment
from app.files.declarations.panel import read_panel
from app.rig import new_declarations
from app.rig.new_declarations import NewExperiment, new_experiment, new_panel
from drivers.ni.cards import Action, DaqError
from drivers.ni.connection import Device

Flexura = Callable[..., tuple[int, str, str]]
PLATE = (0.3, 0.2, 0.003, 0.162)
CHASSIS = (
    Device("cDAQ2", "cDAQ-9178", (), (), simulated=False),
    Device("cDAQ2Mod4", "NI 9234", ("cDAQ2Mod4/ai0", "cDAQ2Mod4/ai1", "cDAQ2Mod4/ai2"), (), simulated=False),
    Device("cDAQ2Mod5", "NI 9260", (), ("cDAQ2Mod5/ao0",), simulated=False),
)


@pytest.fixture(autouse=True)
def ports(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the serial ports of this computer."""
    found: list[str] = ["/dev/ttyUSB3"]
    port = type("Port", (), {})
    made = lambda: [type("Port", (port,), {"device": name})() for name in found]  # noqa: E731
    monkeypatch.setattr(new_declarations, "serial_ports", made)
    return found


def test_an_experiment_has_the_plate_and_the_devices_found(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    missing = new_experiment(file, NewExperiment(PLATE, oven="watlow-f4t"), lambda: CHASSIS)
    made = read_acquired_experiment(file)
    assert (made.title, made.rig) == ("mine", "real")
    assert (made.plate.length_x, made.plate.mass) == (0.3, 0.162)
    assert made.cards.output == "cDAQ2Mod5/ao0"
    assert made.cards.inputs == ("cDAQ2Mod4/ai0", "cDAQ2Mod4/ai1")
    assert (made.oven.kind, made.oven.place) == ("watlow-f4t", "/dev/ttyUSB3")
    assert made.patch[0].center == pytest.approx((0.2 * 0.3 / 0.24, 0.155 * 0.2 / 0.19), abs=1e-6)
    said = " ".join(missing)
    assert "found NI 9260 and NI 9234" in said
    assert "the only one of this computer" in said
    with pytest.raises(ResultFileError, match="is there already"):
        new_experiment(file, NewExperiment(PLATE), lambda: CHASSIS)


def test_without_driver_and_with_several_ports_it_says_what_is_there(tmp_path: Path, ports: list[str]) -> None:
    ports.append("/dev/ttyUSB4")

    def none() -> tuple[Device, ...]:
        raise DaqError("listing devices", "no driver here", None, Action.STOP, "install it")

    missing = new_experiment(tmp_path / "a.toml", NewExperiment(), none)
    said = " ".join(missing)
    assert "the NI driver says: no driver here" in said
    assert "this computer has: /dev/ttyUSB3, /dev/ttyUSB4" in said
    assert "[plate] is the example's" in said
    missing = new_experiment(tmp_path / "b.toml", NewExperiment(port="COM7"), lambda: CHASSIS[:1])
    assert read_acquired_experiment(tmp_path / "b.toml").oven.place == "COM7"
    assert "no device with an output and two inputs" in " ".join(missing)


def test_what_makes_no_experiment_is_refused_and_leaves_no_file(tmp_path: Path) -> None:
    with pytest.raises(CampaignFileError, match="toaster"):
        new_experiment(tmp_path / "a.toml", NewExperiment(PLATE, oven="toaster"), lambda: CHASSIS)
    with pytest.raises(CampaignFileError, match="plate"):
        new_experiment(tmp_path / "a.toml", NewExperiment((0.3, 0.2, 5.0, 0.1)), lambda: CHASSIS)
    assert list(tmp_path.iterdir()) == []


def test_a_panel_keeps_patches_at_their_shares(tmp_path: Path) -> None:
    new_panel(tmp_path / "door.toml", PLATE, "")
    made = read_panel(tmp_path / "door.toml")
    assert (made.title, made.plate.length_y, len(made.patch)) == ("door", 0.2, 6)
    assert made.patch[0].center == pytest.approx((0.035 * 0.3 / 0.24, 0.105 * 0.2 / 0.19), abs=1e-6)
    with pytest.raises(ResultFileError):
        new_panel(tmp_path / "small.toml", (0.03, 0.02, 0.003, 0.002), "")
    assert not (tmp_path / "small.toml").exists()


def test_the_verb_writes_both(tmp_path: Path, run_flexura: Flexura, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(new_declarations, "_devices", lambda: CHASSIS)
    words = ("--plate", *map(str, PLATE))
    status, _, err = run_flexura("new", "experiment", *words, "--oven", "watlow-f4t", "--out", tmp_path)
    assert status == 0, err
    assert "experiment.toml: complete it, then: flexura doctor" in err
    assert read_acquired_experiment(tmp_path / "experiment.toml").cards.output == "cDAQ2Mod5/ao0"
    assert run_flexura("new", "panel", *words, "--out", tmp_path / "door.toml", "-q")[0] == 0
    for wrong in (
        ("experiment", "--roving", "Hammer"),
        ("panel", "--oven", "watlow-f4t"),
        ("test", "--port", "COM3"),
    ):
        assert run_flexura("new", *wrong)[0] == 2
    (tmp_path / "a.csv").write_text("f\n1\n", encoding="utf-8")
    again = tmp_path / "." / "a.csv"
    status, _, err = run_flexura("new", "test", tmp_path / "a.csv", again)
    assert (status, "a.csv is named twice" in err) == (2, True), err
    status, _, err = run_flexura("new", "experiment", *words[:-1], "--oven", "watlow-f4t")
    assert (status, "four numbers are wanted" in err) == (2, True), err
    status, _, err = run_flexura("new", "experiment", "--kind", "hammer", *words, "--oven", "watlow-f4t")
    assert (status, "is written into its file, with [set_points]" in err) == (2, True), err


def test_at_a_terminal_plate_and_oven_are_asked_for(
    tmp_path: Path, run_flexura: Flexura, monkeypatch: pytest.MonkeyPatch
) -> None:
    answers = iter([0.4, 0.3, 0.002, 0.22, "watlow-f4t"])
    monkeypatch.setattr("click.prompt", lambda *_, **__: next(answers))
    monkeypatch.setattr("app.commands.new.sys.stdin", type("Terminal", (), {"isatty": lambda self: True})())
    monkeypatch.setattr(new_declarations, "_devices", lambda: CHASSIS)
    status, _, err = run_flexura("new", "experiment", "--out", tmp_path)
    assert status == 0, err
    made = read_acquired_experiment(tmp_path / "experiment.toml")
    assert (made.plate.length_x, made.plate.mass, made.oven.kind) == (0.4, 0.22, "watlow-f4t")
