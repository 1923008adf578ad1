"""The shape of a measured mode, from the updated twin, moving; made in a thread, so that windows go on."""

from collections.abc import Callable
from functools import partial

import numpy as np
from PySide6.QtCore import QThread, Signal
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from analysis.experiment import Experiment
from analysis.material import MaterialLaws
from analysis.progress import Progress
from app.view.recorded.fields import Shapes
from app.view.surface import TURN, Movement, SurfaceChart, edges_of
from app.view.theme import Theme


class Maker(QThread):
    """Makes one thing for a widget, which waits for it before it goes.

    Parameters
    ----------
    task : callable
        Makes it, telling how far it is.
    shown : QLabel
        Shows how far, or what went wrong.
    owner : QWidget

    Attributes
    ----------
    progressed : Signal(str)
        How far it is.
    made, failed : Signal(object)
        The thing, or the words of an error.
    """

    progressed = Signal(str)
    made = Signal(object)
    failed = Signal(object)

    def __init__(self, task: Callable[[Progress], object], shown: QLabel, owner: QWidget) -> None:
        super().__init__(owner)
        self._task = task
        self.progressed.connect(shown.setText)
        self.failed.connect(shown.setText)
        owner.destroyed.connect(self.wait)

    def hand_to(self, take: Callable[..., None]) -> None:
        """Begin, and hand over what is made."""
        self.made.connect(take)
        self.start()

    def run(self) -> None:
        """Work in the thread."""
        try:
            self.made.emit(self._task(lambda stage, share: self.progressed.emit(f"{stage}: {100 * share:.0f} %")))
        except (OSError, ValueError) as error:
            self.failed.emit(str(error))


TWIN_MODES = 80
"""Of the twin, among which the nearest is looked for; the rigid ones are among them."""


class ModeShape(QWidget):
    """The twin's mode nearest to a frequency that was identified.

    Parameters
    ----------
    experiment : Experiment
    laws : MaterialLaws
        Of the plate.
    theme : Theme
    """

    def __init__(self, experiment: Experiment, laws: MaterialLaws, theme: Theme) -> None:
        super().__init__()
        self._experiment, self._theme = experiment, theme
        self._wanted = (20.0, float("nan"))
        self._shapes: Shapes | None = None
        self.chart: SurfaceChart | None = None
        self._status = QLabel("the plate's twin is fetched …")
        self._layout = QVBoxLayout(self)
        self._layout.setContentsMargins(0, 0, 0, 0)
        self._layout.addWidget(self._status)
        self._movement = Movement(self, self._advance)

        def fetched(report: Progress) -> Shapes:
            from app.twins.campaign_twin import campaign_reduction
            from simulation.reduction.reduced_model import lowest_modes

            masses = np.array([footprint.mass for footprint in experiment.footprints])
            reduced = campaign_reduction(experiment, report).loaded(masses)
            return Shapes(
                partial(lowest_modes, reduced), reduced.deflection, reduced.points, experiment.plate.grown(laws)
            )

        self._maker = Maker(fetched, self._status, self)
        self._maker.hand_to(self.show_shapes)

    def show_shapes(self, shapes: Shapes) -> None:
        """Build the plot, once the twin is there."""
        self._shapes, theme = shapes, self._theme
        outlines = [
            (patch.loop.polygon, theme.warning if patch.role == "actuator" else theme.muted)
            for patch in self._experiment.patch
        ]
        edges = edges_of(self._experiment.plate)
        self.chart = SurfaceChart("plate-mode-shape", "", shapes.x, shapes.y, outlines, theme, edges)
        self._status.hide()
        self._layout.addWidget(self.chart)
        self.show_nearest(*self._wanted)
        self._movement.go(moving=True)

    def show_nearest(self, temperature: float, frequency: float) -> None:
        """Show the shape of the twin's mode nearest to `frequency`, Hz, at a temperature; nothing for NaN."""
        self._wanted = temperature, frequency
        if self._shapes is None or self.chart is None:
            return
        if not np.isfinite(frequency):
            self.chart.setTitle("not identified at this temperature")
            return
        f, eta, shapes = self._shapes.lowest(temperature, TWIN_MODES)
        nearest = int(np.abs(f - frequency).argmin())
        self.chart.show_field(shapes[nearest].astype(complex))
        self.chart.setTitle(f"the twin's mode {nearest + 1}: {f[nearest]:.1f} Hz, η {100 * eta[nearest]:.2f} %")

    def play_or_stop(self) -> None:
        """Let it move, or stand still."""
        if self.chart is not None:
            self._movement.toggle()

    def _advance(self) -> None:
        if self.chart is not None and self.isVisible():
            self.chart.turn(TURN)
