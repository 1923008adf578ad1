"""A described cause as an effect of one's own: loaded, verified, and acting as it was described."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analysis.estimates import Estimate
from analysis.experiment import Experiment
from analysis.gap.description.describing import Curve, Dependence, Description, Form
from analysis.gap.description.place_map import PlaceMap
from analysis.material import LocalLaws
from analysis.recordings.sweep_point import SweepPoint
from app.files.declarations.experiment import read_acquired_experiment
from app.files.results.described_effect import write_described_effect
from app.files.results.gap_json import description_record
from app.summaries.gap import description_words
from simulation.effects.free_curves import KNOTS, LOAD, free_effects, knots
from simulation.effects.library import load_folder
from simulation.state.plate_state import Circumstances, PlateState

EXAMPLE = Path(__file__).parents[4] / "examples" / "hidden-effect.toml"
PLACE = (Estimate("x", 0.13, 0.001, "m"), Estimate("y", 0.08, 0.001, "m"))
MAP = PlaceMap(np.array([[0.1, 0.1]]), np.zeros((3, 1)), np.ones((3, 1)), np.ones(3), np.zeros(3))
CURVE = Curve(
    np.array([100.0, 400.0, 1500.0]), np.array([[1e-3, 2e-3, -1e-3], [0.0, 3e-3, 0.0]]), np.full((2, 3), 1e-5)
)
FORMS = {
    "mass": (Estimate("mass", 2e-3, 1e-5, "kg"), *PLACE),
    "spring": (Estimate("stiffness", 1500.0, 20.0, "N/m"), *PLACE),
    "dashpot": (Estimate("damping", 1.5, 0.02, "N s/m"), *PLACE),
    "resonator": (
        Estimate("mass", 6e-4, 1e-5, "kg"),
        *PLACE,
        Estimate("resonance", 420.0, 1.0, "Hz"),
        Estimate("loss", 0.08, 0.002, "1"),
    ),
    "load": PLACE,
    "modulus": (),
    "gain": (),
}


def described(name: str, **changes: object) -> Description:
    parameters = FORMS[name]
    curve = CURVE if name in ("load", "modulus", "gain") else None
    form = Form(name, f"load_{name}", {one.name: one.value for one in parameters}, parameters, 50.0, 0.99, curve)
    same = Dependence("temperature", ("0 °C", "60 °C"), np.array([1.01, 0.99]), np.array([0.02, 0.02]))
    form = replace(form, **changes)  # type: ignore[arg-type]
    return Description(form, (form,), MAP, (same,), {})


@pytest.fixture(scope="module")
def experiment() -> Experiment:
    acquired = read_acquired_experiment(EXAMPLE)
    return acquired.recorded(acquired.sample_rate)


def state(experiment: Experiment, frequency: np.ndarray) -> tuple[Circumstances, PlateState]:
    point = SweepPoint(20.0, 0.0, 1.0)
    laws = LocalLaws(20.0, np.array([21.0, 0.36, -2.6]), np.zeros(3), np.zeros(3))
    grid = np.zeros(4)
    return Circumstances.of(experiment, point, frequency), PlateState.baseline(grid, grid, laws, 20.0, frequency)


@pytest.mark.parametrize("name", FORMS)
def test_every_form_is_an_effect_that_passes_the_checks(name: str, experiment: Experiment, tmp_path: Path) -> None:
    file = write_described_effect(tmp_path, described(name))
    effects = load_folder(file.parent, experiment)
    assert list(effects) == [f"described_{name}"]


@pytest.mark.parametrize("name", ["mass", "spring", "dashpot", "resonator"])
def test_a_form_acts_as_the_free_load_of_its_curve(name: str, experiment: Experiment, tmp_path: Path) -> None:
    """Its dynamic stiffness is -w**2 (a - j b) with the apparent mass of the textbook."""
    file = write_described_effect(tmp_path, described(name))
    (effect,) = load_folder(file.parent, experiment).values()
    frequency = knots(experiment.protocol.band, KNOTS)
    circumstances, plain = state(experiment, frequency)
    values = {one.name: one.value for one in FORMS[name]}
    (one,) = effect.apply(plain, circumstances, values).attached
    omega = 2.0 * np.pi * frequency
    pole = (2.0 * np.pi * 420.0) ** 2 * (1.0 + 0.08j)
    apparent = {
        "mass": 2e-3 + 0j * omega,
        "spring": -1500.0 / omega**2 + 0j,
        "dashpot": -1.5j / omega,
        "resonator": 6e-4 * pole / (pole - omega**2),
    }[name]
    amounts = {f"a{k}": float(m.real) for k, m in enumerate(apparent)}
    amounts |= {f"b{k}": float(-m.imag) for k, m in enumerate(apparent)}
    free = free_effects(experiment)[LOAD].apply(plain, circumstances, {**amounts, "x": 0.13, "y": 0.08})
    np.testing.assert_allclose(one.stiffness, free.attached[0].stiffness, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(one.loss, free.attached[0].loss, rtol=1e-9, atol=1e-6)


def test_an_older_description_is_removed(experiment: Experiment, tmp_path: Path) -> None:
    write_described_effect(tmp_path, described("mass"))
    file = write_described_effect(tmp_path, described("gain"))
    assert [one.name for one in file.parent.glob("*.py")] == ["described_gain.py"]


def test_words_say_what_where_and_on_what_it_depends() -> None:
    found = described("mass", also=((0.11, 0.11),))
    words = description_words({"description": description_record(found, "described/described_mass.py")})
    assert words[0].replace("\u00a0", " ") == (
        "What is missing acts like an added mass of 2.000 ± 0.010 g near x 130.0 ± 1.0 mm, y 80.0 ± 1.0 mm, alike "
        "at all temperatures."
    )
    assert "would look the same near x\u00a0110, y\u00a0110" in words[1]
    assert "99\u00a0%" in words[2]
    assert "--effects RUN/described" in words[3]


def test_words_say_how_it_changes() -> None:
    grows = Dependence("temperature", ("0 °C", "60 °C"), np.array([0.5, 1.5]), np.array([0.02, 0.03]))
    found = replace(described("spring"), dependence=(grows,))
    words = description_words({"description": description_record(found)})
    assert words[1].replace("\u00a0", " ") == (
        "Its strength changes with the temperature: 0.50 ± 0.02 at 0 °C, 1.50 ± 0.03 at 60 °C (1: in the mean)."
    )


def test_a_description_without_evidence_describes_nothing() -> None:
    (said,) = description_words({"description": description_record(described("gain", nats=1.0))})
    assert "neither like a load" in said
    assert description_words({}) == []


@pytest.mark.parametrize(
    ("name", "word"), [("modulus", "loss factor"), ("gain", "phase"), ("load", "apparent mass")]
)
def test_curves_are_told_at_both_ends_of_the_band(name: str, word: str) -> None:
    said = description_words({"description": description_record(described(name))})[0].replace("\u00a0", " ")
    assert word in said
    assert "100 Hz" in said
