"""The windows: pictures a second, and how soon a large campaign is there.

    python benchmarks/view.py

The waterfall (31 temperatures, 1401 lines) with both cursors moving, and a field of 1200 points turning, are drawn
into memory as `flexura view` draws them; the plain way draws the same anew with matplotlib. A run ten times as
long is opened from its files; the plain way reads and draws everything in them first. All in processor time, of
which a window uses one core's: on a busy machine the clock would measure the others.
"""

import json
import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402

from analysis.identification.modes import Modes  # noqa: E402
from analysis.identification.over_temperature.tracked_modes import TrackedModes  # noqa: E402
from analysis.identification.pole_residue import NONE  # noqa: E402
from analysis.recordings.frf import Frf  # noqa: E402
from app.files.declarations.experiment import read_acquired_experiment  # noqa: E402
from app.files.provenance import provenance  # noqa: E402
from app.files.results.modes_file import load_frf, load_modes, save_frf, save_modes  # noqa: E402  # noqa: E402
from app.view.application import application  # noqa: E402
from app.view.folder import viewed  # noqa: E402
from app.view.frf_plots import decibels  # noqa: E402
from app.view.recorded.window import RecordedWindow  # noqa: E402
from app.view.surface import SurfaceChart  # noqa: E402
from app.view.theme import LIGHT  # noqa: E402

NATURAL = np.linspace(150.0, 1450.0, 18)
FREQUENCY = np.linspace(100.0, 1500.0, 1401)


def modes_at(temperature: float) -> Modes:
    """Eighteen modes that sink with temperature."""
    poles = 2.0 * np.pi * NATURAL * (1.0 - 0.005 * temperature) * (-0.03 + 1j)
    size = len(poles)
    return Modes(
        poles=poles,
        residues=30.0 * np.exp(1j * np.arange(size))[None],
        covariance=np.broadcast_to(1e-6 * np.eye(2), (size, 2, 2)).copy(),
        terms=NONE,
        coefficients=np.zeros((1, 0), complex),
        status=("kept",) * size,
        reason=("",) * size,
        band=(100.0, 1500.0),
        misfit=0.01,
        lines=len(FREQUENCY),
    )


def write_run(folder: Path, sweeps: int) -> None:
    """Write a run folder of `sweeps` temperatures."""
    folder.mkdir()
    temperature = np.linspace(0.0, 60.0, sweeps)
    modes = tuple(modes_at(float(t)) for t in temperature)
    h = np.array([m.synthesis(FREQUENCY) for m in modes])
    way, level = ("up",) * sweeps, np.ones(sweeps)
    noise = np.full(h.shape, 1e-8)
    frf = Frf(temperature, way, level, FREQUENCY, h, noise, 1.0 - noise, np.zeros(len(FREQUENCY), bool), ("S1",))
    experiment = read_acquired_experiment(ROOT / "examples" / "simulated-rig.toml").recorded(51200.0 / 6.0)
    made = provenance({"benchmark": "0"})
    save_frf(folder / "frf.h5", experiment, frf, made)
    track = np.tile(np.arange(len(NATURAL)), (sweeps, 1))
    save_modes(folder / "modes.h5", TrackedModes(temperature, way, level, ("S1",), modes, track, 0), made)


def rate(draw: Callable[[int], Any], pictures: int) -> float:
    """Pictures a second."""
    draw(0)
    started = time.process_time()
    for number in range(1, pictures + 1):
        draw(number)
    return pictures / (time.process_time() - started)


def waterfall(folder: Path) -> tuple[float, float]:
    """Pictures a second with the cursors moving, ours and plain; both show the same numbers."""
    app = application()
    window = RecordedWindow(viewed(folder), LIGHT)
    window.show()
    app.processEvents()
    frf = load_frf(folder / "frf.h5")[1]
    level = decibels(frf.h[:, 0])

    def ours(number: int) -> None:
        window.cursors.frequency = float(FREQUENCY[(37 * number) % len(FREQUENCY)])
        window.cursors.temperature = float(frf.temperature[number % len(frf.temperature)])
        app.processEvents()

    figure = Figure(figsize=(14.4, 9.0))
    canvas = FigureCanvasAgg(figure)

    def plain(number: int) -> None:
        row, line = number % len(frf.temperature), (37 * number) % len(FREQUENCY)
        figure.clear()
        axes = figure.subplots(2, 2)
        axes[0, 0].pcolormesh(FREQUENCY, frf.temperature, level)
        axes[0, 1].plot(level[:, line], frf.temperature)
        axes[1, 0].plot(FREQUENCY, level[row])
        axes[1, 1].plot(FREQUENCY, np.angle(frf.h[row, 0]))
        canvas.draw()

    fast, slow = rate(ours, 120), rate(plain, 4)
    shown = {label: y for label, _, y in window.findChild(object, "frf-at-temperature").curves}
    if not np.allclose(shown["measured"], level[120 % len(frf.temperature)]):
        raise RuntimeError("the cut is not that of the sweep at the cursor")
    window.close()
    return fast, slow


def field() -> tuple[float, float]:
    """Pictures a second of a turning field, ours and plain."""
    app = application()
    x, y = np.linspace(0.0, 0.8, 40), np.linspace(0.0, 0.6, 30)
    values = np.exp(-40.0 * np.add.outer((x - 0.5) ** 2, (y - 0.3) ** 2) + 9j * np.add.outer(x, y))
    corners = np.array([[0.4, 0.2], [0.6, 0.2], [0.6, 0.4], [0.4, 0.4]])
    chart = SurfaceChart("field", "field", x, y, [(corners, LIGHT.warning)], LIGHT)
    chart.resize(700, 420)
    chart.show()
    chart.show_field(values)

    def ours(_: int) -> None:
        chart.turn(0.1)
        app.processEvents()

    figure = Figure(figsize=(7.0, 4.2))
    canvas = FigureCanvasAgg(figure)
    plane = np.meshgrid(x, y, indexing="ij")

    def plain(number: int) -> None:
        figure.clear()
        axes = figure.add_subplot(projection="3d")
        axes.plot_surface(*plane, np.real(values * np.exp(0.1j * number)), rcount=40, ccount=30, cmap="coolwarm")
        canvas.draw()

    fast, slow = rate(ours, 120), rate(plain, 4)
    if not np.allclose(chart.deflection, np.real(values / np.abs(values).max() * np.exp(0.1j * 121))):
        raise RuntimeError("the field is not the one that was turned")
    return fast, slow


def opening(folder: Path) -> tuple[float, float]:
    """Seconds until a run is on the screen, ours and by reading all of it and drawing every page first."""
    app = application()
    started = time.process_time()
    window = RecordedWindow(viewed(folder), LIGHT)
    window.show()
    app.processEvents()
    ours = time.process_time() - started
    window.close()
    started = time.process_time()
    load_frf(folder / "frf.h5")
    load_modes(folder / "modes.h5").synthesis(FREQUENCY)
    window = RecordedWindow(viewed(folder), LIGHT)
    window.show()
    for number in range(window.tabs.count()):
        window.page(number)
    app.processEvents()
    return ours, time.process_time() - started


def main() -> None:
    """Measure, print and keep the figures."""
    with tempfile.TemporaryDirectory() as scratch:
        small, large = Path(scratch) / "small-run", Path(scratch) / "large-run"
        write_run(small, 31)
        write_run(large, 310)
        moving, drawn = waterfall(small)
        turning, plotted = field()
        opened, read = opening(large)
    record = {
        "waterfall_pictures_per_s": moving,
        "waterfall_plain_pictures_per_s": drawn,
        "field_pictures_per_s": turning,
        "field_plain_pictures_per_s": plotted,
        "open_310_sweeps_s": opened,
        "open_310_sweeps_plain_s": read,
    }
    ratio = moving / drawn
    print(f"waterfall 31 x 1401, cursors moving: {moving:.0f} pictures/s; matplotlib {drawn:.1f}; {ratio:.0f} x")
    print(f"field of 1200 points: {turning:.0f} pictures/s; matplotlib {plotted:.1f}; {turning / plotted:.0f} x")
    print(f"310 sweeps on the screen after {opened:.2f} s; with everything read and drawn first {read:.2f} s")
    target = ROOT / "benchmarks" / "results" / "view.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps(record, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
