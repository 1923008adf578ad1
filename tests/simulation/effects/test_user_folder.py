"""A user's effects: a good file takes part, a bad one is refused with its name and the reason."""

import re
import shutil

import pytest

from simulation.effects.library import apply_all, library, untried

PATTERN = """
from analysis.effect_card import EffectCard, Parameter
from simulation.effects.effect import Effect


def card(experiment):
    return EffectCard(
        name="{name}",
        summary="a layer of lacquer on the plate",
        parameters=(Parameter("mass", "kg/m2", 0.0, 1.0, 0.05),),
        needs="modes over two octaves",
        separated_by="weigh the plate before and after",
    )


def apply(state, circumstances, values):
    mass = values["mass"]
    {body}


EFFECT = Effect(card, apply)
"""
GOOD = "return state.with_(area_mass=state.area_mass + mass)"


def write(folder, name="lacquer", body=GOOD, file=None):
    path = folder / (file or f"{name}.py")
    path.write_text(PATTERN.format(name=name, body=body))
    return path


def test_a_good_file_follows_the_library_and_acts_like_the_others(experiment, trial, tmp_path):
    write(tmp_path)
    (tmp_path / "_shared.py").write_text("raise RuntimeError('not an effect')")
    (tmp_path / "readme.txt").write_text("not Python")
    effects = library(experiment, tmp_path)
    assert list(effects) == [*library(experiment), "lacquer"]
    circumstances, state = trial()
    after = apply_all(effects, state, circumstances, {"lacquer": {"mass": 0.3 + 1e-30j}})
    assert set(after.area_mass) == {0.3 + 1e-30j}


def test_files_of_the_library_itself_are_good_files(experiment, tmp_path):
    from simulation.effects import bond_shear_lag

    copy = tmp_path / "glue.py"
    shutil.copy(bond_shear_lag.__file__, copy)
    copy.write_text(copy.read_text().replace('name="bond_shear_lag"', 'name="glue"'))
    assert "glue" in library(experiment, tmp_path)


def test_an_effect_that_is_not_available_is_left_out_unharmed(experiment, tmp_path):
    path = write(tmp_path, body="raise RuntimeError('needs a string')")
    source = path.read_text()
    path.write_text(source.replace("Effect(card, apply)", "Effect(card, apply, lambda e: bool(e.string))"))
    bare = experiment.model_copy(update={"string": ()})
    assert "lacquer" not in library(bare, tmp_path)
    assert untried(bare, tmp_path) == {
        "suspension": "each [[string]] that holds the plate",
        "string_mass": "each [[string]] that holds the plate",
        "lacquer": "modes over two octaves",
    }
    assert untried(experiment) == {}


@pytest.mark.parametrize(
    ("source", "reason"),
    [
        ("card = 1", "defines no EFFECT"),
        ("EFFECT = 'lacquer'", "an EFFECT that is a str"),
        ("def card(:", "cannot be run: SyntaxError"),
        ("import no_such_module_anywhere", "cannot be run: ModuleNotFoundError"),
        ("raise SystemExit(3)", "cannot be run: SystemExit: 3"),
        (
            "from simulation.effects.effect import Effect\nEFFECT = Effect(lambda e: {'a': 1}, lambda s, c, v: s)",
            "card returns a dict; an EffectCard is wanted",
        ),
        (
            "from simulation.effects.effect import Effect\nEFFECT = Effect(lambda e: e.plates, lambda s, c, v: s)",
            "its card cannot be made: AttributeError",
        ),
    ],
)
def test_a_file_without_a_usable_effect_is_refused(experiment, tmp_path, source, reason):
    path = tmp_path / "mine.py"
    path.write_text(source)
    with pytest.raises(ValueError, match=f"{re.escape(str(path))}: .*{re.escape(reason)}"):
        library(experiment, tmp_path)


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ("return state.with_(area_mass=state.area_mass + abs(mass))", "does not give the slope of area_mass"),
        ("return state.with_(area_mass=state.area_mass + mass.real)", "does not give the slope of area_mass"),
        ("return state.with_(area_mass=state.area_mass + float(mass))", "apply fails: TypeError"),
        ("return state.with_(area_mass=state.area_mass + (mass if mass > 0 else 0))", "apply fails: TypeError"),
        ("return state.with_(area_mass=state.area_mass + values['weight'])", "apply fails: KeyError: 'weight'"),
        ("return state.with_(areal_mass=mass)", "apply fails: TypeError"),
        ("return state.with_(area_mass=state.area_mass + np.abs(mass))", "apply fails: NameError"),
        ("return None", "apply fails: "),
        ("return state.with_(area_mass=state.area_mass + mass + 0.1)", "changes area_mass although"),
        ("return state.with_(loss=state.loss * 1.01)", "changes loss although"),
        ("return state", "mass: no slope at zero in anything"),
        ("return state.with_(area_mass=state.area_mass + mass**2)", "mass: no slope at zero in anything"),
        (
            "return state.with_(area_mass=state.area_mass + mass**0.5)",
            "the slope of area_mass is not finite at zero",
        ),
        ("return state.with_(area_mass=state.area_mass + mass * float('inf'))", "changes area_mass although"),
        (
            "return state.with_(area_mass=state.area_mass + 1e308 * mass * (1e10 * mass))",
            "area_mass is not finite",
        ),
        (
            "rim = (state.xi**2 > 0.9) | (state.zeta**2 > 0.9)\n"
            "    return state.with_(density=state.density * (1.0 + mass * rim))",
            "the twin loses 100 % of what it changes of density",  # which its points do not even meet
        ),
        (
            "half = state.xi > 0.0\n    return state.with_(modulus=state.modulus * (1.0 + mass * half))",
            "% of what it changes of modulus: it keeps a field as a polynomial of degree 3",
        ),
    ],
)
def test_an_effect_unfit_for_the_search_is_refused(experiment, tmp_path, body, reason):
    path = write(tmp_path, body=body)
    with pytest.raises(ValueError, match=f"{re.escape(str(path))}: .*{re.escape(reason)}"):
        library(experiment, tmp_path)


E = "e = circumstances.strain_energy; "


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ("return state.with_(loss=state.loss * (1 + mass * e))", None),
        ("return state.with_(log_gain=state.log_gain - mass * e / (1 + e))", None),
        (
            "return state.with_(loss=state.loss * (1 + mass * abs(e)))",
            "strain_energy does not give the slope of loss",
        ),
        (
            "return state.with_(loss=state.loss * (1 + mass * e.sum()))",
            "loss follows the strain energy of another",
        ),
        (
            "return state.with_(thickness=state.thickness * (1 + mass * e[3]))",
            "thickness follows the strain energy",
        ),
        (
            "return state.with_(feedthrough=state.feedthrough + mass * e[3])",
            "feedthrough follows the strain energy",
        ),
    ],
)
def test_strain_energy_acts_on_its_own_line_only(experiment, tmp_path, body, reason):
    path = write(tmp_path, body=E + body)
    path.write_text(
        path.read_text().replace("Effect(card, apply)", "Effect(card, apply, needs_strain_energy=True)")
    )
    if reason is None:
        assert library(experiment, tmp_path)["lacquer"].needs_strain_energy
        return
    with pytest.raises(ValueError, match=f"{re.escape(str(path))}: .*{re.escape(reason)}"):
        library(experiment, tmp_path)


def test_names_must_not_clash(experiment, tmp_path):
    path = write(tmp_path, name="point_mass", file="heavy.py")
    with pytest.raises(ValueError, match=r"heavy\.py: its effect is called 'point_mass', which the library has"):
        library(experiment, tmp_path)
    with pytest.raises(ValueError, match="library has already"):  # also where this one takes no part
        library(experiment.model_copy(update={"cable": ()}), tmp_path)
    path.unlink()
    path = write(tmp_path, name="plate_mass", file="heavy.py")  # a declared quantity
    with pytest.raises(ValueError, match=r"heavy\.py: its effect is called 'plate_mass', which the library has"):
        library(experiment, tmp_path)
    path.unlink()
    write(tmp_path, file="one.py")
    write(tmp_path, file="two.py")
    with pytest.raises(ValueError, match=r"two\.py: its effect is called 'lacquer', as that of one\.py"):
        library(experiment, tmp_path)


def test_a_folder_without_effects_is_refused(experiment, tmp_path):
    with pytest.raises(ValueError, match=r"holds no \*\.py file"):
        library(experiment, tmp_path)
    with pytest.raises(ValueError, match="not a folder"):
        library(experiment, tmp_path / "absent")
