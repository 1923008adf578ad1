import re
from pathlib import Path

import pytest

from app.files.campaign_error import CampaignFileError
from app.files.declarations.experiment import read_acquired_experiment

EXAMPLE = Path(__file__).resolve().parents[4] / "examples" / "simulated-rig.toml"


FORCES = EXAMPLE.with_name("exciter.toml")


def changed(tmp_path: Path, pattern: str, replacement: str, example: Path = EXAMPLE) -> Path:
    text, count = re.subn(pattern, replacement, example.read_text(encoding="utf-8"), count=1, flags=re.MULTILINE)
    assert count == 1
    file = tmp_path / "mine.toml"
    file.write_text(text, encoding="utf-8")
    return file


@pytest.mark.parametrize(
    ("pattern", "replacement", "told"),
    [
        (r"^every = 10.0", "evry = 10.0", r"programme.evry = unknown key; .*did you mean every\?"),
        (r"^ramp_rate = 1.0", 'ramp_rate = "1"', r"programme.ramp_rate = '1'; allowed: a number above 0 to 60"),
        (r"^band = .*", "band = [100.0, 5000.0]", "below half of"),
        (r"^levels = .*", "levels = [4.5]", r"sweep.levels = 4.5 V; allowed: at most 4.24 V"),
        (r"^levels = .*", "levels = [4.0]\ntypo = 1", r"sweep.typo = unknown key"),
        (r"^patch_voltage = .*", "patch_voltage = 10.0", "the patch is rated for 10 V"),
        (r"^max_rate = .*", "max_rate = 0.5", r"programme.ramp_rate = 1 K/min; .* steepest ramp"),
        (r"^hottest = .*", "hottest = 200.0", r"limits.hottest = 200 °C; allowed: at most 95 °C, oven.maximum"),
        (r"^coldest = .*", "coldest = -60.0", r"limits.coldest = -60 °C; allowed: at least -35 °C"),
        (r"^duration = .*", "duration = 60.0", r"the window programme.tolerance leaves"),
        (r"^thermocouples = .*", "", r"names no thermocouple"),
        (r"^responses = .*", 'responses = ["cDAQ1Mod1/ai1", "cDAQ1Mod1/ai2"]', "2 terminals for the 1 sensors"),
        (r"^sample_rate = 8500.0", "sample_rate = 99000.0", r"NI-9234 allows .* to 51200 Hz"),
        (r"^youngs_modulus = .*", "youngs_modulus = [1e9, 1e9, 1e9, 1e9]", "4 values for 9 temperatures"),
        (r"^format = .*", 'format = "experiment/2"', r"format = 'experiment/2'; allowed: 'experiment/1'"),
        (
            r"^thickness = 0.003",
            'thickness = 0.003\nmaterial = { kind = "aluminum" }',
            r"did you mean aluminium\?",
        ),
        (
            r"^thickness = 0.003",
            "thickness = 0.003\nmaterial = { youngs_modulus = [1.5, 1800.0] }",
            r"\[0\] = 1.5; .*\(values are SI: 1.5 GPa are 1.5e\+09\)",
        ),
        (
            r"^thickness = 0.003",
            "thickness = 0.003\nmaterial = { youngs_modulus = [1.5, 1800.0] }",
            r"\[1\] = 1800.0; .*\(values are SI: 1800 MPa are 1.8e\+09\)",
        ),
        (r"^kind = \"watlow-f4t\"", 'kind = "watlow"', "'votsch-ascii2'"),
        (r"^center = \[0.04", "center = [0.24", "the plate allows 0 to 0.24"),
        (r"^room_temperature = 22.0", "room_temperature = 295.0", r"\(295 K are 21.85 °C\)"),
        (
            r"^thickness = 0.003",
            "thickness = 0,003",
            r"thickness = 0,003'; .* \(write 0.003, with a decimal point\)",
        ),
    ],
)
def test_what_is_wrong_is_named_with_file_key_value_and_range(
    tmp_path: Path, pattern: str, replacement: str, told: str
) -> None:
    with pytest.raises(CampaignFileError, match=told) as caught:
        read_acquired_experiment(changed(tmp_path, pattern, replacement))
    assert "mine.toml" in str(caught.value)


@pytest.mark.parametrize(
    ("pattern", "replacement", "told"),
    [
        (
            r"^sensitivity = 0.1 .*",
            "",
            r"drive\[0\].sensitivity = nothing; .* from 1e-06 to 1 \(V/N.*key is missing",
        ),
        (r"^sensitivity = 0.1 ", "sensitivity = 11.2 ", r"drive\[0\].sensitivity = 11.2; .*0.0112"),
        (r"^sensitivity = 50.0 .*", "", r"sensor\[1\].sensitivity = nothing; allowed: .*V per m/s2, m/s or m"),
        (r"^sensitivity_unit.*", "", r"'acc' has sensitivity 100 V per m/s2; 1e-05 to 2 .*mV/g"),
        (
            r"^sensitivity = 50.0",
            'sensitivity_unit = "mV/g"\nsensitivity = 50.0',
            "'laser' has .*measures velocity",
        ),
        (r"^sensitivity = 1e8 .*", "", r"patch\[1\]: patch 'Q1' has quantity charge and no sensitivity; .*V/C"),
        (r"^sensitivity = 1e8 ", "sensitivity = 0.1 ", r"patch\[1\].sensitivity = 0.1; .*1 mV/pC is 1e9 V/C"),
        (r"^quantity = .*", "", r"'Q1' has quantity voltage and sensitivity 1e\+08; .*remove"),
        (r', "cDAQ1Mod4/ai2"', "", r"5 terminals for the 6 sensors .*'laser2', 'gap'\]; one each"),
        (r"^drive_input.*", "", r"cards.drive_input = nothing; allowed: the terminal of the drive's force sensor"),
        (r"^\[exciter\]\n.*\n.*", "", "exciter is missing, but drive 'shaker' is driven; add it"),
        (r"^\[exciter\]", "[amplifier]\ngain = 1.0\n[exciter]", "amplifier is given, but drive 'shaker'"),
        (r"^retries", "patch_voltage = 9.0\nretries", "limits.patch_voltage is given, but .*; remove it"),
        (r"^rated_force = 2.0", "rated_force = 0.2", "at most 0.4 V: the exciter is rated for 0.2 N"),
    ],
)
def test_what_is_wrong_with_forces_and_sensors_is_named(
    tmp_path: Path, pattern: str, replacement: str, told: str
) -> None:
    with pytest.raises(CampaignFileError, match=told) as caught:
        read_acquired_experiment(changed(tmp_path, pattern, replacement, FORCES))
    assert "mine.toml" in str(caught.value)


def test_a_driven_patch_needs_its_amplifier_and_its_rating(tmp_path: Path) -> None:
    for pattern, told in ((r"^\[amplifier\]\n.*", "amplifier"), (r"^patch_voltage.*", "limits.patch_voltage")):
        with pytest.raises(CampaignFileError, match=f"{told} is missing, but patch 'A1' is driven; add it"):
            read_acquired_experiment(changed(tmp_path, pattern, ""))


def test_of_patches_alone_nothing_new_is_dumped() -> None:
    """So that a campaign begun before there were sensitivities is taken up again."""
    dumped = read_acquired_experiment(EXAMPLE).model_dump(mode="json")
    assert dumped.keys().isdisjoint({"drive", "sensor", "exciter"})
    assert set(dumped["patch"][0]) == {"id", "role", "center", "size", "thickness", "side", "material"}
    assert dumped["string"] == dumped["cable"] == []


def test_the_campaign_declares_no_sensitivity() -> None:
    experiment = read_acquired_experiment(FORCES)
    recorded = experiment.recorded(experiment.sample_rate).model_dump(mode="json")
    assert "sensitivity" not in str(recorded)
    assert [one.volts for one in experiment.sensitivities.responses] == pytest.approx(
        [1.0, 1e8, 0.1 / 9.80665, 50.0, 50.0, 2e4]
    )


def test_without_simulation_it_cannot_be_the_simulated_rig(tmp_path: Path) -> None:
    text = EXAMPLE.read_text(encoding="utf-8").split("[simulation]")[0]
    file = tmp_path / "mine.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(CampaignFileError, match=r"no \[simulation\]"):
        read_acquired_experiment(file)
    file.write_text(text.replace('rig = "simulated"', 'rig = "ni"'), encoding="utf-8")
    assert read_acquired_experiment(file).simulation is None


def test_declares_its_campaign_with_the_rate_read_back() -> None:
    experiment = read_acquired_experiment(EXAMPLE)
    recorded = experiment.recorded(8533.0)
    assert recorded.format == "recorded-campaign/1"
    assert recorded.acquisition.sample_rate == 8533.0
    assert recorded.protocol.temperatures == (0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0)
    assert recorded.oven.room_temperature == 22.0


def test_the_declaration_of_a_recorded_campaign_is_sent_to_import() -> None:
    folder = EXAMPLE.parent / "pp-plate"
    with pytest.raises(CampaignFileError) as caught:
        read_acquired_experiment(folder / "campaign.toml")
    assert str(caught.value) == (
        f"{folder}: campaign.toml: declares a recorded campaign (format 'recorded-campaign/1'), "
        f"which flexura import {folder} takes"
    )


def test_a_folder_is_no_experiment() -> None:
    folder = EXAMPLE.parent / "pp-plate"
    with pytest.raises(
        CampaignFileError, match=r"a folder; an experiment is a TOML file; flexura import .*pp-plate"
    ):
        read_acquired_experiment(folder)
    with pytest.raises(CampaignFileError, match=r"examples: a folder; an experiment is a TOML file$"):
        read_acquired_experiment(folder.parent)


def test_responses_are_named_by_sensor_and_terminal() -> None:
    declared = read_acquired_experiment(FORCES)
    protocol = declared.protocol
    names = [output.id for output in declared.recorded(declared.sample_rate).outputs]
    assert [protocol.response(n) for n in range(len(names))] == [
        f"response {name} ({terminal})" for name, terminal in zip(names, declared.cards.responses, strict=True)
    ]
