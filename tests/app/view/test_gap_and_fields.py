"""Pages on the gap, on focusing and on moving fields; the panel is a plate of sines, known in closed form."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.arrays import Complex, Real

pytest.importorskip("PySide6.QtSvg", reason="Qt cannot be loaded here", exc_type=ImportError)

from PySide6.QtCore import QPointF, Qt

from analysis.estimates import FittedLaws
from analysis.experiment import Plate
from analysis.focusing.energy import EnergyForms, FieldSpace, Grid
from analysis.focusing.methods import compare
from analysis.focusing.over_temperature import focus
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import PanelModes
from analysis.focusing.pareto import ParetoCurve
from analysis.focusing.performance import Aim
from analysis.gap.fitting.residual_map import Signature
from app.files.provenance import provenance
from app.files.results.gap_file import GapFigures, GapMap, save_gap
from app.files.results.laws_file import load_laws
from app.files.results.panel_files import save_focusing
from app.twins.campaign_twin import shape_points
from app.view.application import application
from app.view.chart import Map
from app.view.folder import viewed
from app.view.map_chart import MapChart
from app.view.recorded.fields import Shapes
from app.view.recorded.fields_page import FieldsPage
from app.view.recorded.focusing_page import FocusingPage
from app.view.recorded.gap_page import GapPage
from app.view.recorded.window import RecordedWindow
from app.view.surface import FromAbove, SurfaceChart, edges_of, filled
from app.view.theme import LIGHT, one_sided

ORDERS = [(m, n) for m in range(1, 5) for n in range(1, 5)]
PANEL = Panel.model_validate(
    {
        "title": "sines",
        "plate": {"length_x": 0.4, "length_y": 0.3, "thickness": 0.003, "mass": 0.35},
        "patch": [
            {"id": f"A{n}", "role": "actuator", "center": place, "size": (0.02, 0.02), "thickness": 5e-4}
            for n, place in enumerate([(0.09, 0.07), (0.31, 0.08), (0.12, 0.22), (0.3, 0.21)])
        ],
        "target": {"center": (0.3, 0.6), "size": (0.25, 0.3)},
        "grid": (20, 16),
        "filters": {
            "taps": 64,
            "sample_rate": 4000.0,
            "band": (100.0, 300.0),
            "edges": (60.0, 360.0),
            "transform_length": 512,
            "delay": 32,
            "operating_range": (0.0, 40.0),
        },
    }
)


class SinePanel:
    """A simply supported Kirchhoff plate driven by point forces."""

    def __init__(self) -> None:
        grid = Grid.of(PANEL)
        self.space = FieldSpace.of(self._shapes(grid.points), grid)
        self._driven = self._shapes(np.array([patch.center for patch in PANEL.patch]))

    @staticmethod
    def _shapes(points: Real) -> Real:
        lengths = np.array([PANEL.plate.length_x, PANEL.plate.length_y])
        waves = [np.prod(np.sin(np.pi * np.array(o) * points / lengths), axis=1) for o in ORDERS]
        return 2.0 / np.sqrt(PANEL.plate.mass) * np.array(waves).T

    @staticmethod
    def squared(e: float, nu: float, eta: float) -> Complex:
        plate = PANEL.plate
        rigidity = e * plate.thickness**3 / 12.0 / (1.0 - nu**2)
        area_mass = plate.mass / plate.length_x / plate.length_y
        waves = np.array([(m / plate.length_x) ** 2 + (n / plate.length_y) ** 2 for m, n in ORDERS])
        return np.asarray(rigidity / area_mass * (np.pi**2 * waves) ** 2 * (1.0 + 1j * eta))

    def amplitudes(self, e: float, nu: float, eta: float, frequency: Real) -> Complex:
        w = 2.0 * np.pi * frequency
        return np.asarray(self._driven[:, None, :] / (self.squared(e, nu, eta) - w[None, :, None] ** 2))

    def forms(self, e: float, nu: float, eta: float, frequency: Real, displacement: float = 1.0) -> EnergyForms:
        return self.space.forms([self.amplitudes(e, nu, eta, frequency)], displacement)

    def modes(self, e: float, nu: float, eta: float, count: int) -> PanelModes:
        values = self.squared(e, nu, eta)
        order = np.argsort(values.real)[:count]
        return PanelModes(values[order], np.eye(len(values))[:, order], self._driven.T[order])


@pytest.fixture
def focused_run(run: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Write what `focus` leaves, with the sines for a twin."""
    model, laws = SinePanel(), load_laws(run / "laws.h5")
    found = focus(model, PANEL, laws, np.array([0.0, 20.0, 40.0]))
    comparison = compare(model, PANEL, (1.1e9, 0.33, 0.06))
    save_focusing(run / "filters.h5", PANEL, found, comparison, provenance({"laws.h5": "00ff"}))
    monkeypatch.setattr("app.twins.panel_twin.panel_twin", lambda *_: model)
    return run


@pytest.fixture
def opened(shown: Callable[[Any], Any]) -> Callable[[Path], RecordedWindow]:
    def show(folder: Path) -> RecordedWindow:
        application()
        window: RecordedWindow = shown(RecordedWindow(viewed(folder), LIGHT))
        return window

    return show


def page_named(window: RecordedWindow, title: str) -> Any:
    titles = [window.tabs.tabText(number) for number in range(window.tabs.count())]
    return window.page(titles.index(title))


def fields_page(window: RecordedWindow, qtbot: Any) -> FieldsPage:
    page = page_named(window, "Fields")
    assert isinstance(page, FieldsPage)
    qtbot.waitUntil(lambda: page.fields is not None, timeout=60_000)
    return page


def test_maps_and_cuts_of_contrast_follow_choice_and_cursor(
    opened: Callable[[Path], RecordedWindow], focused_run: Path
) -> None:
    window = opened(focused_run)
    page = page_named(window, "Focusing")
    assert isinstance(page, FocusingPage)
    assert window.results.focusing is not None
    found = window.results.focusing[1]
    page._choice.setCurrentIndex(0)
    window.cursors.temperature = 39.0
    shown = page._maps[0].map
    assert shown is not None
    np.testing.assert_array_equal(shown.value, found.direct.contrast)
    cuts = {label: y for label, _, y in page._cuts[1].curves}
    np.testing.assert_allclose(cuts["of 20 °C everywhere"], 100 * found.fixed.spot_error[2])


def test_what_an_even_sound_costs_is_shown_where_the_aim_is_heard(
    opened: Callable[[Path], RecordedWindow], focused_run: Path
) -> None:
    window = opened(focused_run)
    assert window.results.focusing is not None
    assert window.results.pareto is None
    ripple, contrast = np.array([4.0, 0.8, 2.0, 3.0]), np.array([0.9, 0.7, 0.8, 0.75])
    curve = ParetoCurve(20.0, *(np.zeros(4) for _ in range(2)), contrast, contrast, ripple, *np.zeros((2, 4)))
    page = FocusingPage(window.results.focusing[1], None, window.cursors, LIGHT, curve)
    assert page._tradeoff is not None
    drawn = {label: (x.tolist(), y.tolist()) for label, x, y in page._tradeoff.curves}
    assert drawn["not beaten by another"] == ([0.8, 2.0, 4.0], [0.7, 0.8, 0.9])
    assert drawn["recommended"] == ([0.8], [0.7])
    assert len(drawn["designs"][0]) == 4


def test_cuts_of_contrast_name_the_temperature_of_every_curve(
    opened: Callable[[Path], RecordedWindow], focused_run: Path
) -> None:
    window = opened(focused_run)
    assert window.results.focusing is not None
    found = window.results.focusing[1]
    at = np.array([0.0, 10.0, 20.0, 30.0, 40.0])
    shape = (5, len(found.frequency))
    own, learned = (Aim(np.full(shape, level), np.zeros(shape), np.ones(shape, complex)) for level in (0.3, 0.2))
    compensated = SimpleNamespace(
        aim_temperature=at, frequency=found.frequency, direct_aim=own, network_aim=learned
    )
    page = FocusingPage(found, compensated, window.cursors, LIGHT)  # type: ignore[arg-type]
    titles = [cut.plotItem.titleLabel for cut in page._cuts]
    window.cursors.temperature = 20.0
    assert [title.text for title in titles] == ["contrast at 20 °C", "spot error at 20 °C"]
    window.cursors.temperature = 31.0
    exception = "of 20 °C everywhere, at 40 °C"
    assert [title.text for title in titles] == [
        f"{what} at 30 °C; {exception}" for what in ("contrast", "spot error")
    ]
    cuts = {label: y for label, _, y in page._cuts[0].curves}
    np.testing.assert_array_equal(cuts[exception], found.fixed.contrast[2])
    assert set(cuts["of each temperature"]) == {0.3}
    names = page._cuts[0].plotItem.legend
    page.resize(1200, 900)
    page.grab()
    low = page._cuts[0].plotItem.vb.mapSceneToView(names.sceneBoundingRect().bottomLeft()).y()
    assert low > 1.0


def test_the_field_shown_has_the_contrast_its_filters_were_judged_by(
    opened: Callable[[Path], RecordedWindow], focused_run: Path, qtbot: Any
) -> None:
    window = opened(focused_run)
    page = fields_page(window, qtbot)
    assert page.fields is not None
    found, grid = page.fields.focusing, Grid.of(PANEL)
    for row, line in ((0, 3), (2, 20)):
        t, f, field = page.fields.focused(float(found.temperature[row]), float(found.frequency[line]), fixed=False)
        assert (t, f) == (found.temperature[row], found.frequency[line])
        energy = grid.area * np.abs(field.ravel()) ** 2
        assert energy @ grid.target / energy.sum() == pytest.approx(found.uncut.contrast[row, line], rel=1e-9)


def test_mode_shapes_are_those_of_the_plate(
    opened: Callable[[Path], RecordedWindow], focused_run: Path, qtbot: Any
) -> None:
    page = fields_page(opened(focused_run), qtbot)
    assert page.fields is not None
    f, eta, shapes = page.fields.plate.lowest(20.0, 24)
    law = page.fields.plate.laws.at(np.array([20.0]))
    e, nu, loss = (float(x[0]) for x in (law.youngs_modulus, law.poisson_ratio, law.loss_factor))
    expected = np.sort(np.sqrt(SinePanel.squared(e, nu, loss).real)) / 2.0 / np.pi
    np.testing.assert_allclose(f, expected, rtol=1e-12)
    np.testing.assert_allclose(eta, loss)
    x, y = page.fields.plate.x, page.fields.plate.y
    first = np.outer(np.sin(np.pi * x / 0.4), np.sin(np.pi * y / 0.3))
    np.testing.assert_allclose(shapes[0] / shapes[0].max(), first / first.max(), atol=1e-12)


def test_modes_are_offered_as_far_as_the_twin_is_certified(
    opened: Callable[[Path], RecordedWindow], focused_run: Path, qtbot: Any
) -> None:
    page = fields_page(opened(focused_run), qtbot)
    assert page.fields is not None
    every, _, shapes = page.fields.plate.lowest(20.0, 24)
    f, eta, offered = page.fields.modes(20.0)
    low, high = PANEL.filters.twin_band
    within = (every >= low) & (every <= high)
    assert 2 < within.sum() < len(every)
    np.testing.assert_array_equal(f, every[within])
    assert len(eta) == page._mode_choice.count() == len(f)
    np.testing.assert_array_equal(offered, shapes[within])


def test_modes_below_the_twins_band_and_motion_within_the_plane_are_no_modes(
    opened: Callable[[Path], RecordedWindow], focused_run: Path, qtbot: Any
) -> None:
    page = fields_page(opened(focused_run), qtbot)
    assert page.fields is not None
    low, high = PANEL.filters.twin_band
    frequency = np.array([0.4, 0.9 * low, 1.01 * low, 80.0, 150.0, 1.01 * high])
    level = np.array([1.0, 1.0, 1.0, 1e-3, 0.5, 1.0])  # that at 80 Hz bends nothing

    def modes(*_: object) -> tuple[Complex, Real]:
        return (2.0 * np.pi * frequency) ** 2 * (1.0 + 0.05j), np.eye(len(ORDERS))[:, : len(level)] * level

    page.fields = replace(page.fields, plate=replace(page.fields.plate, modes=modes))
    np.testing.assert_allclose(page.fields.modes(20.0)[0], [1.01 * low, 150.0])
    page._refresh()
    assert page._mode_choice.count() == 2
    frequency[[2, 4]] = 5000.0
    page._refresh()
    assert page._mode_choice.count() == 0
    assert page.shape.plotItem.titleLabel.text.startswith("no mode of the panel from 46 to 468 Hz")
    assert not page.shape.deflection.any()
    page.step(1)


def test_fields_turn_stand_still_and_are_exported_as_seen(
    opened: Callable[[Path], RecordedWindow], focused_run: Path, qtbot: Any, tmp_path: Path
) -> None:
    window = opened(focused_run)
    page = fields_page(window, qtbot)
    before = page.field.deflection
    qtbot.waitUntil(lambda: bool(np.abs(page.field.deflection - before).max() > 0.05), timeout=60_000)
    qtbot.keyClick(window, Qt.Key.Key_Space)
    still = page.field.deflection
    qtbot.wait(200)
    np.testing.assert_array_equal(page.field.deflection, still)
    written = window.export(tmp_path)
    assert {"focused-field.csv", "mode-shape.svg", "field-amplitude.png"} <= {path.name for path in written}
    table = np.genfromtxt(tmp_path / "focused-field.csv", delimiter=",", skip_header=1)
    np.testing.assert_allclose(table[:, 1:], still.T, atol=1e-8)
    page.step(2)
    assert page.shape.plotItem.titleLabel.text.startswith("mode 3 of the panel")


def test_a_surface_shows_the_real_part_of_a_turning_field(qtbot: Any) -> None:
    application()
    x, y = np.linspace(0.0, 0.4, 9), np.linspace(0.0, 0.3, 7)
    chart = SurfaceChart("surface", "", x, y, [(np.array([[0.1, 0.1], [0.2, 0.1], [0.2, 0.2]]), "#ff0000")], LIGHT)
    qtbot.addWidget(chart)
    chart.show()
    field = 3.0 * np.exp(1j * np.add.outer(x, y) * 9.0)
    chart.show_field(field)
    blank = chart.grab().toImage()
    chart.turn(0.7)
    np.testing.assert_allclose(chart.deflection, np.real(field / 3.0 * np.exp(0.7j)), atol=1e-12)
    assert chart.grab().toImage() != blank


def test_cells_of_a_map_stand_where_their_frequencies_are(qtbot: Any) -> None:
    chart = MapChart("map", "", "x", "y", LIGHT)
    qtbot.addWidget(chart)
    x, y = np.array([100.0, 120.0, 200.0, 400.0, 1000.0]), np.array([0.0, 10.0, 40.0])
    value = np.arange(15.0).reshape(3, 5)
    image = chart.image(Map(x, y, value), one_sided(), (0.0, 15.0), "")
    box = image.mapRectToParent(image.boundingRect())
    for frequency, temperature, cell in ((112.0, 2.0, 1), (190.0, 4.0, 2), (320.0, 30.0, 13), (690.0, 7.0, 8)):
        column = int((frequency - box.left()) / box.width() * image.image.shape[1])
        row = int((temperature - box.top()) / box.height() * image.image.shape[0])
        assert image.image[row, column] == cell


def gap_map(size: float) -> GapMap:
    sigma = np.ones((4, 2, 6))
    sigma[1:3, 0, 4] = size
    return GapMap(
        edges=np.linspace(100.0, 700.0, 7),
        temperature=np.array([0.0, 20.0, 20.05, 40.0]),
        level=np.ones(4),
        direction=("up",) * 4,
        channels=("S1", "S2"),
        sigma=sigma,
        excess=50.0 * (sigma**2 - 1.0),
    )


@pytest.fixture
def gap_run(run: Path) -> Path:
    laws = FittedLaws(np.array([0.0, 20.0]), np.array([[21.8, 0.35, -2.6]] * 2), np.full((2, 3), 1e-3))
    figures = GapFigures(gap_map(9.0), gap_map(1.0), laws, laws)
    row = {"log_evidence_screened": 480.0, "log_evidence_fitted": 512.0, "share": 0.99}
    record = {
        "verdict": "explained",
        "effects": [
            {
                "name": "point_mass",
                "equivalent": [],
                "parameters": {"mass": {"value": 7.9e-4, "sigma": 1e-5, "unit": "kg"}},
            }
        ],
        "gap": {"baseline": {"chi2_per_dof": 8.0}, "final": {"chi2_per_dof": 1.01}},
        "candidates": [
            {"name": "point_mass", **row},
            {"name": "suspension", **row, "share": 0.5},
            {"name": "orthotropy", "log_evidence_screened": 1.0, "log_evidence_fitted": None, "share": None},
        ],
    }
    sigma = figures.before.sigma
    signatures = (
        Signature("point_mass", np.ones_like(sigma), True),
        Signature("suspension", np.sqrt(sigma), True),
        Signature("orthotropy", 2.0 * sigma, False),
    )
    save_gap(run / "gap.h5", figures, signatures, record, provenance({"a": "0"}))
    return run


def test_signatures_are_switched_on_and_off(opened: Callable[[Path], RecordedWindow], gap_run: Path) -> None:
    window = opened(gap_run)
    page = page_named(window, "Gap")
    assert isinstance(page, GapPage)
    assert page.switched_on == ["point_mass"]

    def loudest() -> float:
        shown = page._signature.map
        assert shown is not None
        return float(shown.value.max())

    assert loudest() == 0.0
    page.switch("suspension", on=True)
    page.switch("point_mass", on=False)
    assert page.switched_on == ["suspension"]
    assert loudest() == pytest.approx(np.log10(3.0))
    page.switch("suspension", on=False)
    assert loudest() == pytest.approx(np.log10(9.0))
    page.switch("orthotropy", on=True)
    assert page.switched_on == ["orthotropy"]
    assert loudest() == pytest.approx(np.log10(18.0))
    page.switch("suspension", on=True)
    assert loudest() == pytest.approx(np.log10(3.0))


def test_the_verb_writes_every_page_as_a_picture(
    qapp: object, run_flexura: Callable[..., tuple[int, str, str]], gap_run: Path, tmp_path: Path
) -> None:
    shots = tmp_path / "shots"
    status, out, err = run_flexura("view", gap_run, "--theme", "light", "--screenshot", shots, "--json")
    pictures = [Path(name) for name in json.loads(out)["pictures"]]
    assert (status, err) == (0, f"{len(pictures)} pictures in {shots}\n")
    assert sorted(shots.iterdir()) == sorted(pictures)
    assert "view-gap-light.png" in {picture.name for picture in pictures}
    assert all(picture.read_bytes().startswith(b"\x89PNG") for picture in pictures)
    assert run_flexura("view", gap_run, "--screenshot", shots, "--quiet") == (0, "", "")


def test_the_gap_map_is_that_of_the_sensor_chosen(opened: Callable[[Path], RecordedWindow], gap_run: Path) -> None:
    page = page_named(opened(gap_run), "Gap")
    before, after = page._before.map, page._after.map
    assert 10 ** before.value.max() == pytest.approx(9.0)
    assert after.value.max() == 0.0
    assert before.y.tolist() == pytest.approx([0.0, 20.025, 40.0])
    page._channel.setCurrentIndex(1)
    assert page._before.map.value.max() == 0.0


def test_a_field_on_any_outline_is_shown_between_its_edges_and_left_open_off_the_plate(qtbot: Any) -> None:
    application()
    plate = Plate.model_validate(
        {
            "outline": {"kind": "circle", "center": (0.0, 0.0), "radius": 0.15},
            "hole": [{"kind": "circle", "center": (0.05, 0.0), "radius": 0.04}],
            "thickness": 0.003,
            "mass": 0.2,
        }
    )
    points = shape_points(plate)
    assert plate.contains(points).all()
    assert len(points) < 0.75 * 32**2
    shapes = Shapes(SinePanel.squared, np.zeros((0, 0)), points, None)  # type: ignore[arg-type]
    field = shapes.on_grid((points @ (1.0, 2.0)).astype(complex))
    assert np.isfinite(field).sum() == len(points)
    x, y = shapes.x, shapes.y
    lattice = x[:, None] + 2.0 * y
    np.testing.assert_array_equal(field.real[np.isfinite(field)], lattice[np.isfinite(field)])
    whole = filled(field)
    assert np.isfinite(whole).all()
    np.testing.assert_array_equal(whole[np.isfinite(field)], field[np.isfinite(field)])
    straight = filled(np.pad(field, 2, constant_values=np.nan))[2:-2, 2:-2]
    near = np.isfinite(np.pad(field, 1, constant_values=np.nan)[2:, 1:-1])
    np.testing.assert_allclose(straight.real[near], lattice[near], atol=0.02)
    above = FromAbove(x, y, plate).amplitude(field)
    places = np.stack(np.meshgrid(above.x, above.y), axis=-1)
    on = plate.contains(places.reshape(-1, 2)).reshape(above.value.shape)
    np.testing.assert_array_equal(np.isfinite(above.value), on)
    np.testing.assert_allclose(above.value[on], np.abs(places @ (1.0, 2.0))[on], atol=0.02)
    chart = SurfaceChart("round", "", x, y, [], LIGHT, edges_of(plate))
    qtbot.addWidget(chart)
    chart.resize(500, 400)
    chart.show_field(np.where(np.isfinite(field), 1.0 + 0.0j, np.nan))
    chart.show()
    qtbot.waitExposed(chart)
    picture = chart.grab().toImage()

    def color(at: tuple[float, float]) -> tuple[int, int, int]:
        u, v = chart._item._projected(np.array([at]), np.ones(1))
        seen = chart.plotItem.vb.mapViewToScene(QPointF(float(u[0]), float(v[0])))
        place = chart.mapFromScene(seen)
        ratio = picture.devicePixelRatio()
        pixel = picture.pixelColor(round(place.x() * ratio), round(place.y() * ratio))
        return pixel.red(), pixel.green(), pixel.blue()

    ground = color((0.149, 0.149))
    assert color((0.05, 0.0)) == ground
    assert all(color(place) != ground for place in ((-0.05, 0.0), (0.0, 0.1), (0.0, -0.1)))
