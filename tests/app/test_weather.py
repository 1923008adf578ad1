"""``flexura compensate`` and ``flexura render`` in a weather: a small panel, and the section-2 panel in a car."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.io import wavfile
from scipy.signal import fftconvolve

import flexura as library
from analysis.compensation.settings import Training
from analysis.focusing.panel import Panel
from analysis.material import MaterialLaws
from analysis.radiation.radiator import Radiator
from analysis.rendering.renderer import SAMPLES_BEFORE_ZERO, impulse_responses
from analysis.weather.judged import ONE, OWN_TILTED, SEVERAL, TILTED, WAYS
from app.chain.links import compensate_inputs, do_compensate
from app.chain.work import RunRequest, Work
from app.files.campaign_error import CampaignFileError
from app.files.declarations.panel import SECTION_2, read_panel, read_weather
from app.files.declarations.run_settings import read_run_options
from app.files.provenance import sha256
from app.files.results.laws_file import load_laws
from app.files.results.panel_files import load_compensation, load_panel
from app.files.shipped import shipped
from app.main import flexura
from app.report.focusing import lost_in_weather
from app.report.page import Picture
from app.report.panel_sections import compensation_section
from app.sound.rendering import ListenersOfPanel
from app.sound.trace import WeatherOfPanel
from app.stages import compensate as compensate_stage
from app.twins.warm_twin import warm_twin

soundfile = pytest.importorskip("soundfile")
RATE = 4_000
WEATHER = """\
format = "weather/1"
duration = 600.0
step = 10.0
initial = 8.0

[front]
convection = 25.0
air = [[0.0, 8.0], [500.0, 50.0]]
across = [[0.0, 0.0, 0.0], [300.0, 16.0, 6.0]]

[back]
air = [[0.0, 8.0], [500.0, 48.0]]

[[thermometer]]
name = "left"
point = [0.02, 0.095]

[[thermometer]]
name = "lower right"
point = [0.22, 0.02]

[[thermometer]]
name = "upper right"
point = [0.22, 0.17]
"""


def flex(*words):
    return CliRunner().invoke(flexura, [str(word) for word in words])


@pytest.fixture(scope="module")
def weather(tmp_path_factory):
    path = tmp_path_factory.mktemp("weather") / "car.toml"
    path.write_text(WEATHER, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def judged(small_run, weather, tmp_path_factory):
    """Return a run folder that was judged in the weather, and what was printed."""
    folder = small_run.laws_alone(tmp_path_factory.mktemp("judged") / "run")
    result = flex("compensate", folder, "--panel", small_run.panel, "--weather", weather, "--json")
    assert result.exit_code in (0, 1), result.output
    return folder, json.loads(result.stdout), result.stderr


def test_three_thermometers_and_the_tilt_lose_less_than_one(judged):
    folder, told, said = judged
    ways = told["weather"]["ways"]
    assert tuple(ways) == WAYS
    assert ways[TILTED]["loss_worst_line"] < 0.1 * ways[SEVERAL]["loss_worst_line"]
    assert ways[TILTED]["loss"] < 0.01
    assert ways[TILTED]["level_db"] < 0.2 * ways[ONE]["level_db"]
    assert "K from one place to another; filters robust for tilts of" in said
    _, found = load_compensation(folder / "compensation.h5")
    assert found.weather is not None
    assert found.family is not None
    assert found.weather.largest[WAYS.index(TILTED), 1] == pytest.approx(ways[TILTED]["loss_worst_line"])
    plate = told["weather"]["plate_c"]
    assert plate["mean"][0] == pytest.approx(8.0, abs=1e-6)
    assert plate["coldest"][-1] < told["weather"]["readings_c"]["left"][-1] < plate["warmest"][-1]


def test_the_report_draws_what_each_way_loses(judged):
    folder, told, _ = judged
    _, found = load_compensation(folder / "compensation.h5")
    figure = lost_in_weather(found.weather)
    above, below = figure.axes
    assert [line.get_label() for line in below.lines] == list(WAYS)
    for line, way in zip(below.lines, WAYS, strict=True):
        assert max(line.get_ydata()) == pytest.approx(max(told["weather"]["ways"][way]["loss_worst_line"], 1e-5))
    assert {text.get_text() for text in above.texts} == {"left", "lower right", "upper right"}
    assert "What does a panel cost that is not evenly warm?" in [
        item.question for item in compensation_section(folder, []) if isinstance(item, Picture)
    ]


def test_sound_follows_the_thermometers_and_the_tilt(judged, weather, tmp_path):
    folder, *_ = judged
    sound = tmp_path / "noise.wav"
    soundfile.write(sound, 0.3 * np.random.default_rng(4).standard_normal(400 * RATE), RATE, subtype="DOUBLE")
    tilted = flex("render", sound, folder, "--weather", weather, "--out", tmp_path, "--json")
    assert tilted.exit_code == 0, tilted.output
    assert "filters follow the middle of the panel and its tilt" in tilted.stderr
    assert "the sound ends after 400 of 600 s of the weather" in tilted.stderr
    (moments,) = (json.loads(tilted.stdout)["moments"],)
    assert moments[-1]["temperature_c"] > moments[0]["temperature_c"] + 20.0
    fixed = f"{moments[0]['temperature_c']}:{moments[-1]['temperature_c']}"
    plain = flex("render", sound, folder, "--temperature", fixed, "--out", tmp_path, "--json")
    assert plain.exit_code == 0, plain.output
    last = json.loads(plain.stdout)["moments"][-1]
    assert moments[-1]["contrast_worst"] != pytest.approx(last["contrast_worst"], abs=1e-4)
    assert moments[-1]["contrast_mean"] > moments[-1]["kept_mean"]


SUDDEN = """\
format = "weather/1"
duration = 16.0
step = 0.1
heat.specific_heat = 100.0  # a plate that follows the air in a quarter of a second

[front]
convection = 500.0
air = [[4.3, 20.0], [4.6, 30.0]]
across = [[4.3, 0.0, 0.0], [4.6, 16.0, 6.0]]

[back]
convection = 500.0
air = [[4.3, 20.0], [4.6, 30.0]]
across = [[4.3, 0.0, 0.0], [4.6, 16.0, 6.0]]

[[thermometer]]
name = "middle"
point = [0.12, 0.095]
"""


def test_listeners_hear_the_panel_with_its_field_of_temperatures(judged, tmp_path):
    """Before a sudden change the sound is that of an evenly warm panel, after it that of a tilted one."""
    folder, *_ = judged
    sound, air = tmp_path / "noise.wav", tmp_path / "sudden.toml"
    soundfile.write(sound, 0.3 * np.random.default_rng(4).standard_normal(14 * RATE), RATE, subtype="DOUBLE")
    air.write_text(SUDDEN, encoding="utf-8")
    done = flex("render", sound, folder, "--weather", air, "--heard", "--out", tmp_path, "--json")
    assert done.exit_code == 0, done.output
    assert "pascals (1 Pa per unit) at axis" in done.stderr
    panel = load_panel(folder / "compensation.h5")
    laws = panel.plate.grown(load_laws(folder / "laws.h5"))
    twin = warm_twin(panel, laws, lambda _stage, _share: None)
    around = WeatherOfPanel.of(twin, read_weather(air), str(air), None, lambda _stage, _share: None)
    assert np.ptp(around.field(3.0)) < 0.01
    assert np.ptp(around.field(14.0)) > 15.0
    for kept in ("", "-kept"):
        heard = wavfile.read(tmp_path / f"noise-heard{kept}.wav")[1]
        if not kept:
            volts = wavfile.read(tmp_path / "noise-rendered.wav")[1]
            for time, part in ((2.0, slice(4_000, 12_000)), (14.0, slice(36_000, 56_000))):
                errors = [_missed(answer, panel, volts, heard, part) for answer in _answers(twin, around, time)]
                assert errors[0] < 0.01, time
                if time > 4.0:
                    assert errors[1] > 0.05  # by the mean temperature alone
        assert np.isfinite(heard).all()


def _answers(twin, around, time):
    """Responses of the panel with its field at a time, and with its mean temperature everywhere."""
    field = around.field(time)
    listeners = ListenersOfPanel.of(twin.uniform, twin.panel, twin.laws)
    grid = twin.space.grid
    radiator = Radiator(grid.points, grid.area, twin.panel.sound.air, twin.panel.sound.mounting)
    places = np.array([one.position for one in twin.panel.listeners])

    def warm(_state, lines):
        seen = radiator.pressure(places, lines) @ twin.space.deflection
        return np.einsum("lfr,nfr->lfn", seen, twin.answer(field, lines).amplitude)

    return warm, lambda _state, lines: listeners.response(float(field.mean()), lines)[: len(places)]


def _missed(answer, panel, volts, heard, part):
    """Error of what is heard, as a share, beside the volts through the responses of a panel at rest."""
    impulses = impulse_responses(answer, panel.filters, 0.0)[0]
    exact = sum(fftconvolve(volts[:, n], impulses[n]) for n in range(volts.shape[1]))[SAMPLES_BEFORE_ZERO:]
    return np.linalg.norm(heard[part] - exact[part]) / np.linalg.norm(exact[part])


def test_c_code_follows_the_thermometers_if_asked_to(judged, small_run, tmp_path):
    folder, *_ = judged
    plain = flex("export", folder, "--to", "c", "--out", tmp_path / "plain")
    assert plain.exit_code == 0, plain.output
    assert "the filters of the tilt are left out" in plain.stderr
    done = flex(
        "export", folder, "--to", "c", "--number", "int16", "--tilt", "--out", tmp_path / "tilted", "--json"
    )
    assert done.exit_code == 0, done.output
    assert "left out" not in done.stderr
    header = (tmp_path / "tilted" / "flexura_filters.h").read_text()
    assert "#define FLEXURA_THERMOMETERS 3" in header
    assert '"left\\nlower right\\nupper right"' in (tmp_path / "tilted" / "flexura_filters.c").read_text()
    ours = library.export_filters(folder, "c", number="int16", tilt=True, out=tmp_path / "ours")
    assert [path.read_bytes() for path in ours] == [
        (tmp_path / "tilted" / path.name).read_bytes() for path in ours
    ]
    never = flex("export", small_run.folder, "--to", "c", "--tilt", "--out", tmp_path / "never")
    assert never.exit_code != 0
    assert "no filters of the tilt; they are made with: flexura compensate --weather FILE" in never.stderr
    other = flex("export", folder, "--to", "npz", "--tilt")
    assert (other.exit_code, "--tilt is for --to c" in other.stderr) == (2, True)


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("initial = 8.0", "initial = -8.0", "it takes parts of the plate to -8.0 and"),
        ("point = [0.22, 0.17]", "point = [0.26, 0.17]", "thermometer 'upper right' at [0.26, 0.17] m is off the"),
        ("convection = 25.0", 'convection = "much"', "front.convection"),
        ("step = 10.0", "steps = 10.0", "did you mean step?"),
        ("[500.0, 50.0]]", "[500.0, 320.0]]", "320.0"),
        ("[0.0, 8.0], [500.0, 48.0]", "[9.0, 8.0], [5.0, 48.0]", "times must ascend"),
        ("duration = 600.0", "duration = ", "line 2"),
    ],
)
def test_a_weather_that_cannot_be_is_refused_with_a_sentence(judged, small_run, tmp_path, before, after, said):
    folder, *_ = judged
    assert before in WEATHER
    path = tmp_path / "wrong.toml"
    path.write_text(WEATHER.replace(before, after), encoding="utf-8")
    result = flex("compensate", folder, "--panel", small_run.panel, "--weather", path, "--out", tmp_path / "out")
    assert isinstance(result.exception, SystemExit), result.output
    assert said in result.stderr
    assert not (tmp_path / "out" / "compensation.h5").exists()


def test_options_that_contradict_a_weather_are_refused(judged, weather, tmp_path):
    folder, *_ = judged
    sound = tmp_path / "noise.wav"
    soundfile.write(sound, np.zeros(RATE), RATE)
    both = flex("render", sound, folder, "--weather", weather, "--temperature", 20)
    neither = flex("render", sound, folder)
    other = flex("compensate", folder, "--weather", weather, "--method", "time-reversal")
    assert [one.exit_code for one in (both, neither, other)] == [2, 2, 2]
    assert "name one of --temperature and --weather" in both.stderr
    assert "name one of --temperature and --weather" in neither.stderr
    assert "--weather judges filters of the method stif" in other.stderr


def test_the_library_judges_in_a_weather_as_the_verb_does(small_run, weather, tmp_path, monkeypatch):
    folder, asked = small_run.laws_alone(tmp_path / "run"), {}
    monkeypatch.setattr(compensate_stage, "compute", lambda *_, **options: asked.update(options))

    def save(_run, _found, inputs, _extent):
        asked.update(inputs=inputs)
        raise InterruptedError

    monkeypatch.setattr(compensate_stage, "save", save)
    with pytest.raises(InterruptedError):
        library.compensate(folder, small_run.panel, weather=weather, out=folder)
    assert asked["weather"] == (read_weather(weather), str(weather))
    assert asked["inputs"]["car.toml"] == sha256(weather)


def test_a_run_judges_in_the_weather_of_its_options(small_run, weather, tmp_path, monkeypatch):
    folder, asked = small_run.laws_alone(tmp_path / "run"), {}
    file = tmp_path / "run.toml"
    file.write_text(
        f'[run.focus]\npanel = "{small_run.panel}"\n[run.compensate]\nweather = "car.toml"\n', encoding="utf-8"
    )
    (tmp_path / "car.toml").write_text(weather.read_text(encoding="utf-8"), encoding="utf-8")
    work = Work(RunRequest(tmp_path, folder, options=read_run_options(tmp_path, file, ())), folder)
    work.models = SimpleNamespace(wait_for=lambda *_: None)

    def compute(*_, **options):
        asked.update(options)
        raise InterruptedError

    monkeypatch.setattr(compensate_stage, "compute", compute)
    with pytest.raises(InterruptedError):
        do_compensate(work, lambda _stage, _share: None)
    assert asked["weather"] == (read_weather(weather), str(tmp_path / "car.toml"))
    assert compensate_inputs(work)["car.toml"] == sha256(weather)
    typed = read_run_options(tmp_path, file, ("compensate.weather=elsewhere.toml",))
    assert Path(typed.settings.compensate.weather) == Path.cwd() / "elsewhere.toml"
    (tmp_path / "car.toml").unlink()
    with pytest.raises(CampaignFileError, match=r"car\.toml"):
        do_compensate(work, lambda _stage, _share: None)


@pytest.mark.slow
@pytest.mark.parametrize("aimed_at", ["field", "listeners"])
def test_three_thermometers_hold_contrast_and_level_of_the_section_2_panel_in_a_warming_car(aimed_at):
    """A car from -10 °C, 20 K across: at most .01 of the mean contrast, .04 at the worst line, ±1 dB."""
    knots = np.concatenate([[-20.0] * 4, [70.0] * 4])
    log_e = np.log(3.2e9) - np.log(3.2) * (np.linspace(-20.0, 70.0, 4) / 60.0)
    coefficients = np.array([log_e, np.full(4, 0.38), np.full(4, np.log(0.07))])
    laws = MaterialLaws(knots, coefficients, np.zeros((3, 4, 4)), (-10.0, 60.0))
    declared = read_panel(SECTION_2).model_dump(mode="json")
    declared["filters"] |= {"aim": aimed_at, "operating_range": [-10.0, 60.0]}
    panel = Panel.model_validate_json(json.dumps(declared), strict=True)
    path = shipped("warming-car.toml")
    computed = compensate_stage.compute(
        panel,
        laws,
        lambda _stage, _share: None,
        training=Training(epochs=5, restarts=1),
        spacing=10.0,
        weather=(read_weather(path), str(path)),
    )
    found = computed.compensation.weather
    assert found is not None
    assert 19.0 < found.widest < 22.0
    assert found.extent[0, 1] == pytest.approx(-10.0)
    assert found.extent[-1, 2] > 55.0
    for way in (TILTED, OWN_TILTED):
        mean, worst = found.largest[WAYS.index(way)]
        assert mean <= 0.01
        assert worst <= 0.04
        assert found.level_error[WAYS.index(way)] <= 1.0
    one = found.largest[WAYS.index(ONE)]
    assert one[0] > 0.01
    assert one[1] > 0.04
