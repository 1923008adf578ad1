"""The script that places actuators: its plate against Leissa's, its layouts where patches may be."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

from app.files.panel_file import SECTION_2, read_panel

SCRIPT = Path(__file__).resolve().parents[2] / "examples" / "place_actuators.py"


@pytest.fixture
def script(monkeypatch):
    spec = importlib.util.spec_from_file_location("place_actuators", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "place_actuators", module)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "MODES", 16)
    return module


def run(script, monkeypatch, *words):
    monkeypatch.setattr(sys, "argv", ["place_actuators.py", *map(str, words)])
    script.main()


def test_the_clamped_square_has_leissas_frequencies(script):
    whole = script.integrals((1.0, 1.0), [(0.0, 1.0), (0.0, 1.0)])
    values = eigh(whole.bending, whole.mass, eigvals_only=True)[:4]
    np.testing.assert_allclose(np.sqrt(values), [35.99, 73.41, 73.41, 108.3], rtol=1e-3)


def test_patches_stiffen_the_plate_and_load_it(script):
    panel = read_panel(SECTION_2)
    layouts = script.Layouts(panel, [(1.1e9, 0.33, 0.06)], np.array([200.0]))
    stiffness, mass, _ = layouts.patch(0.12, 0.095)
    assert np.linalg.eigvalsh(stiffness).min() > -1e-6 * np.abs(stiffness).max()
    # A patch at the middle adds its mass times the square of the first shape there.
    middle = script.polynomials(np.array([0.12]), 0.24, 0)[0, :, None] * script.polynomials(
        np.array([0.095]), 0.19, 0
    )
    first = float(middle.ravel() @ layouts.shapes[:, 0])
    patch = panel.patch[0]
    assert mass[0, 0] == pytest.approx(layouts.weight * patch.size[0] * patch.size[1] * first**2, rel=0.06)


def test_a_search_from_the_panels_patches_ends_higher_and_off_the_zones(script, monkeypatch, tmp_path, capsys):
    out, panel = tmp_path / "placed.toml", read_panel(SECTION_2)
    zone = (0.0, 0.0, 0.24, 0.06)
    run(script, monkeypatch, "--refine", "--patches", 7, "--pitch", 0.04, "--keep-out", *zone, "--out", out)
    found = read_panel(out)
    centers = np.array(found.centers)
    assert len(centers) == 7
    assert (centers[:, 1] - 0.01 >= 0.06 - 1e-9).all()
    apart = np.abs(centers[:, None] - centers[None]).max(axis=-1) + np.eye(7)
    assert apart.min() >= 0.0249 - 1e-9
    lines = np.arange(100.0, 800.0, 20.0)
    layouts = script.Layouts(panel, [(1.1e9, 0.33, 0.06)], lines)
    assert layouts.score(centers[None])[0] > layouts.score(np.array([panel.centers]))[0]
    assert "bound" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--temperature", 40), "--temperature needs --laws"),
        (("--patches", 0), "--patches 0: at least 1"),
        (("--laws", "nowhere"), "nowhere/laws.h5"),
        (("--refine", "--keep-out", 0.0, 0.0, 0.24, 0.19), "its own patches, where --refine begins, are too near"),
    ],
)
def test_what_cannot_be_placed_is_refused_in_a_sentence(script, monkeypatch, capsys, words, said):
    with pytest.raises(SystemExit) as ended:
        run(script, monkeypatch, *words)
    assert said in f"{ended.value}{capsys.readouterr().err}".replace("\\", "/")


@pytest.mark.parametrize("band", [(100.0, 300.0), (100.0, 800.0), (600.0, 900.0)])
def test_lines_of_the_search_stay_in_the_band(script, band):
    lines = script.search_lines(*band)
    assert lines.min() == band[0]
    assert band[1] - 40.0 < lines.max() <= band[1]
    assert (np.diff(lines) > 0.0).all()


def test_what_is_reached_is_told_for_bands_on_one_side_of_540_hz(script, capsys):
    layouts = script.Layouts(read_panel(SECTION_2), [(1.1e9, 0.33, 0.06)], script.search_lines(100.0, 300.0))
    script.report(layouts, np.array(read_panel(SECTION_2).centers), [])
    told = capsys.readouterr().out
    assert "below 540 Hz" in told
    assert "above" not in told


def test_fewer_patches_than_the_search_begins_with_are_refused(script, monkeypatch, capsys):
    with pytest.raises(SystemExit):
        run(script, monkeypatch, "--refine", "--patches", 3)
    assert "--refine begins at the panel's 6" in capsys.readouterr().err
