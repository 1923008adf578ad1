"""The script that places actuators: its plate against Leissa's, its layouts where patches may be."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

from app.files.declarations.panel import SECTION_2, read_panel
from app.files.settings_toml import toml_text

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
        (("--laws", "nowhere"), "nowhere: does not exist; make it with: flexura update"),
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


def one_like(**changes):
    panel = read_panel(SECTION_2)
    patch = panel.patch[0].model_dump(exclude={"size", "diameter", "angle"}) | changes
    return panel.model_copy(update={"patch": (type(panel.patch[0]).model_validate(patch),)})


def patch_of(script, at, **changes):
    return script.Layouts(one_like(**changes), [(1.1e9, 0.33, 0.06)], np.array([200.0])).patch(*at)


def test_a_patch_is_what_separate_integrals_along_its_sides_give(script):
    panel, at, size = one_like(size=(0.03, 0.02)), (0.07, 0.11), (0.03, 0.02)
    layouts = script.Layouts(panel, [(1.1e9, 0.33, 0.06)], np.array([200.0]))
    exact = script.integrals(layouts.lengths, [(c - 0.5 * s, c + 0.5 * s) for c, s in zip(at, size, strict=True)])
    stiffness, mass, load = layouts.patch(*at)
    shapes = layouts.shapes
    expected = shapes.T @ (exact.bending + layouts.nup * exact.poisson) @ shapes
    np.testing.assert_allclose(stiffness, expected, atol=1e-10 * np.abs(expected).max())
    np.testing.assert_allclose(mass, layouts.weight * shapes.T @ exact.mass @ shapes, atol=1e-10 * mass.max())
    np.testing.assert_allclose(load, shapes.T @ exact.load, atol=1e-10 * np.abs(load).max())


def test_a_patch_turned_by_a_right_angle_is_one_with_its_sides_exchanged(script):
    turned = patch_of(script, (0.07, 0.11), size=(0.03, 0.02), angle=90.0)
    plain = patch_of(script, (0.07, 0.11), size=(0.02, 0.03))
    for one, other in zip(turned, plain, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-10 * np.abs(other).max())


def test_points_of_turned_and_round_patches_have_their_area_and_moments(script):
    """Of a disc ∫x² = πd⁴/64; of a rectangle a × b turned by α, ab (a² cos²α + b² sin²α)/12."""
    (disc,), (turned,) = one_like(diameter=0.025).patch, one_like(size=(0.03, 0.02), angle=30.0).patch
    for patch, area, moment in (
        (disc, np.pi * 0.025**2 / 4.0, np.pi * 0.025**4 / 64.0),
        (turned, 6e-4, 6e-4 * (0.03**2 * 0.75 + 0.02**2 * 0.25) / 12.0),
    ):
        points, weights = script.footprint(patch)
        assert weights.sum() == pytest.approx(area, rel=1e-12)
        assert weights @ points[:, 0] ** 2 == pytest.approx(moment, rel=1e-12)
    product = np.prod(script.footprint(turned)[0], axis=1) @ script.footprint(turned)[1]
    assert product > 0.0  # the longer side rises with x: turned against the clock, as in a panel's file


@pytest.mark.parametrize("shape", [{"size": (0.03, 0.01), "angle": 40.0}, {"diameter": 0.02}])
def test_turned_and_round_patches_are_placed_as_they_are(script, monkeypatch, tmp_path, shape):
    source, out = tmp_path / "panel.toml", tmp_path / "placed.toml"
    panel = read_panel(SECTION_2)
    patches = [
        patch.model_dump(mode="json", exclude_none=True, exclude={"size", "diameter", "angle"}) | shape
        for patch in panel.patch
    ]
    table = panel.model_dump(mode="json", exclude_none=True) | {"patch": patches}
    source.write_text(toml_text(table, "test"), encoding="utf-8")
    run(script, monkeypatch, source, "--starts", 1, "--patches", 2, "--pitch", 0.06, "--out", out)
    found = read_panel(out)
    assert len(found.patch) == 2
    assert {(p.angle, p.diameter) for p in found.patch} == {(shape.get("angle", 0.0), shape.get("diameter"))}


def test_patches_of_several_kinds_are_refused(script, monkeypatch, tmp_path):
    table = read_panel(SECTION_2).model_dump(mode="json", exclude_none=True)
    table["patch"][1]["angle"] = 20.0
    source = tmp_path / "panel.toml"
    source.write_text(toml_text(table, "test"), encoding="utf-8")
    with pytest.raises(SystemExit, match="2 kinds of patches; all are placed like the first"):
        run(script, monkeypatch, source)
