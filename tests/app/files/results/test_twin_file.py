"""Twin files: round trip, other versions, and everything a hand or a stranger may do to one."""

from pathlib import Path

import pytest

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.channels import read_experiment
from app.files.results.twin_file import (
    Basis,
    Estimated,
    TwinEffect,
    TwinFile,
    TwinLaws,
    TwinOrigin,
    read_twin,
    require_known_effects,
    require_same_plate,
    write_twin,
)

EXAMPLE = Path(__file__).resolve().parents[4] / "examples" / "pp-plate"
CARDS = {
    "point_mass": EffectCard("point_mass", "", (Parameter("mass", "kg", 0.0, 0.02, 0.001),), "", ""),
    "thermal_lag": EffectCard("thermal_lag", "", (Parameter("tau", "s", 0.0, 900.0, 200.0),), "", ""),
}


@pytest.fixture(scope="module")
def experiment() -> Experiment:
    return read_experiment(EXAMPLE)


@pytest.fixture
def twin(experiment: Experiment) -> TwinFile:
    declared = {
        name: getattr(experiment, name)
        for name in TwinFile.model_fields
        if hasattr(experiment, name) and name != "format"
    }
    return TwinFile(
        **declared,
        gain=Estimated(value=16.5, sigma=0.001, unit="V/V"),
        laws=TwinLaws(
            temperature_range=(0.0, 20.0),
            temperature=(0.0, 10.0, 20.0),
            youngs_modulus=(3.2e9, 2.8e9, 2.3e9),
            sigma_youngs_modulus=(1e5, 1e5, 1e5),
            poisson_ratio=(0.34, 0.35, 0.37),
            sigma_poisson_ratio=(1e-5, 1e-5, 1e-5),
            loss_factor=(0.05, 0.07, 0.08),
            sigma_loss_factor=(1e-5, 1e-5, 1e-5),
        ),
        effect=(TwinEffect(name="point_mass", parameter={"mass": Estimated(value=8e-4, sigma=1e-5, unit="kg")}),),
        basis=Basis(operators="ab" * 32, error=1e-4),
        origin=TwinOrigin(flexura="0.1.0", campaign="pp", inputs="cd" * 32, verdict="explained"),
    )


@pytest.fixture
def file(twin: TwinFile, tmp_path: Path) -> Path:
    write_twin(tmp_path / "twin.toml", twin)
    return tmp_path / "twin.toml"


def test_round_trip(file: Path, twin: TwinFile, experiment: Experiment) -> None:
    again = read_twin(file)
    assert again == twin
    assert again.effects == {"point_mass": {"mass": 8e-4}}
    assert again.experiment() == experiment
    require_same_plate(file, again, experiment)
    require_known_effects(file, again, CARDS)


def test_a_twin_found_with_one_actuator_holds_for_the_next(
    file: Path, twin: TwinFile, experiment: Experiment
) -> None:
    held = twin.patch[0].model_copy(update={"role": "shorted"})
    require_same_plate(file, twin.model_copy(update={"patch": (held, *twin.patch[1:])}), experiment)
    read = twin.patch[0].model_copy(update={"role": "sensor"})
    with pytest.raises(CampaignFileError, match=r"patch\[0\]\.role"):
        require_same_plate(file, twin.model_copy(update={"patch": (read, *twin.patch[1:])}), experiment)


def test_the_file_is_for_people(file: Path) -> None:
    text = file.read_text(encoding="utf-8")
    assert text.startswith("# A twin of Flexura. SI units")
    assert '[[effect]]\nname = "point_mass"\n\n[effect.parameter]\nmass = { value = 0.0008,' in text
    assert max(len(line) for line in text.splitlines()) < 120


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('format = "flexura-twin/1"', 'format = "flexura-twin/9"', "newer Flexura"),
        ('format = "flexura-twin/1"', 'format = "experiment/1"', "allowed: 'flexura-twin/1'"),
        ('format = "flexura-twin/1"', "format = [1]", "format = [1]"),
        ('format = "flexura-twin/1"\n', "", "format = nothing"),
        ("thickness = 0.003\n", "thickness = 3.0\n", "plate.thickness = 3.0"),
        ("value = 0.0008", "value = nan", "effect[0].parameter.mass.value"),
        ("value = 0.0008", "value = 1e999", "effect[0].parameter.mass.value"),
        ("value = 0.0008", 'value = "0.0008"', "effect[0].parameter.mass.value = '0.0008'; allowed: a number"),
        ("sigma = 1e-05", "sigma = -1e-05", "effect[0].parameter.mass.sigma = -1e-05"),
        ('name = "point_mass"', 'name = "../../etc/passwd"', "effect[0].name"),
        ("temperature = [0.0, 10.0, 20.0]", "temperature = [0.0, 20.0, 10.0]", "must ascend: 10 follows 20"),
        ("temperature = [0.0, 10.0, 20.0]", "temperature = [0.0, 20.0]", "has 3 values for 2 temperatures"),
        ("poisson_ratio = [0.34,", "poisson_ratio = [0.64,", "laws.poisson_ratio[0] = 0.64"),
        ("[gain]\nvalue = 16.5", "[gain]\nvalue = 0.0", "gain.value 0 must be above 0"),
        ("[gain]", "[[gain]]", "gain"),
        ("[basis]", "shell = 'rm -rf /'\n\n[basis]", "shell"),
        ('operators = "abab', 'operators = "../abab', "basis.operators"),
        ("error = 0.0001", "error = " + "9" * 5000, "cannot be parsed"),
        ("error = 0.0001", "error = " + "[" * 5000, ""),
        ("[oven]", "[oven", "line"),
        (
            'format = "flexura-twin/1"',
            'format = "flexura-twin/1"\neffect = []',
            "allowed: TOML (effect = ... stands above: remove that line)",
        ),
    ],
)
def test_a_spoilt_file_is_refused_with_file_key_and_value(file: Path, old: str, new: str, said: str) -> None:
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(CampaignFileError) as refused:
        read_twin(file)
    assert "twin.toml" in str(refused.value)
    assert said in str(refused.value)
    assert len(str(refused.value)) < 20_000


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", b"\x00" * 100, b"a = 1\n" * 400_000])
def test_what_is_no_twin_at_all_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "twin.toml"
    path.write_bytes(content)
    with pytest.raises(CampaignFileError, match=r"twin\.toml"):
        read_twin(path)
    with pytest.raises(CampaignFileError, match="cannot be read"):
        read_twin(tmp_path / "absent.toml")


def test_an_effect_may_stand_once(file: Path) -> None:
    text = file.read_text(encoding="utf-8")
    effect = text[text.index("[[effect]]") : text.index("[basis]")]
    file.write_text(text.replace(effect, effect * 2), encoding="utf-8")
    with pytest.raises(CampaignFileError, match="each may occur once"):
        read_twin(file)


def test_a_twin_of_another_plate_is_refused_with_both_values(
    file: Path, twin: TwinFile, experiment: Experiment
) -> None:
    heavier = experiment.model_copy(update={"plate": experiment.plate.model_copy(update={"mass": 0.2})})
    with pytest.raises(CampaignFileError, match=r"plate\.mass = 0\.12996; allowed: 0\.2 .*one plate"):
        require_same_plate(file, twin, heavier)
    round_one = experiment.patch[0].model_copy(update={"size": None, "diameter": 0.02})
    rounded = experiment.model_copy(update={"patch": (round_one, *experiment.patch[1:])})
    with pytest.raises(CampaignFileError, match=r"patch\[0\]\.diameter = nothing; allowed: 0\.02 "):
        require_same_plate(file, twin, rounded)
    more = experiment.model_copy(update={"cable": ()})
    with pytest.raises(CampaignFileError, match="cable = 1 tables; allowed: 0 tables"):
        require_same_plate(file, twin, more)


def test_another_recorder_on_the_same_plate_is_welcome(file: Path, twin: TwinFile, experiment: Experiment) -> None:
    other = experiment.acquisition.model_copy(update={"sample_rate": 10_000.0, "module": "NI-9231"})
    require_same_plate(file, twin, experiment.model_copy(update={"acquisition": other}))
    loaded = experiment.acquisition.model_copy(update={"input_resistance": 1e6})
    with pytest.raises(CampaignFileError, match=r"acquisition\.input_resistance"):
        require_same_plate(file, twin, experiment.model_copy(update={"acquisition": loaded}))


@pytest.mark.parametrize(
    ("name", "parameter", "said"),
    [
        ("ghost", {"mass": (8e-4, "kg")}, r"effect\[0\].name = 'ghost'; allowed: point_mass, thermal_lag"),
        (
            "pointmass",
            {"mass": (8e-4, "kg")},
            r"\(did you mean point_mass\?; a user's own needs --effects FOLDER\)",
        ),
        ("point_mass", {"tau": (8e-4, "kg")}, r"effect\[0\].parameter = tau; allowed: exactly mass"),
        ("point_mass", {"mass": (8e-4, "g")}, r"parameter.mass.unit = 'g'; allowed: 'kg'"),
        ("point_mass", {"mass": (0.8, "kg")}, r"parameter.mass.value = 0.8; allowed: 0 to 0.02 kg"),
    ],
)
def test_effects_are_held_against_the_library(
    file: Path, twin: TwinFile, name: str, parameter: dict[str, tuple[float, str]], said: str
) -> None:
    values = {p: Estimated(value=v, sigma=0.0, unit=u) for p, (v, u) in parameter.items()}
    changed = twin.model_copy(update={"effect": (TwinEffect(name=name, parameter=values),)})
    with pytest.raises(CampaignFileError, match=said):
        require_known_effects(file, changed, CARDS)
