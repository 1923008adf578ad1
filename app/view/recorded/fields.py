"""Mode shapes of the panel and the field its filters make, from the twin that designed them."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from analysis.arrays import Complex, Real
from analysis.focusing.over_temperature import Focusing
from analysis.focusing.panel import Panel
from analysis.material import MaterialLaws
from app.files.hdf5_file import result_file
from app.files.provenance import read_stamp
from app.view.recorded.shapes import Shapes

if TYPE_CHECKING:
    from app.twins.panel_twin import PanelTwin

MOST_SHAPES = 24
"""Shapes offered at most."""


@dataclass(frozen=True)
class Fields:
    """What can be animated.

    Attributes
    ----------
    panel : Panel
    focusing : Focusing
    twin : PanelTwin
    plate : Shapes
        Of the same twin.
    """

    panel: Panel
    focusing: Focusing
    twin: "PanelTwin"
    plate: Shapes

    @classmethod
    def of(
        cls, panel: Panel, focusing: Focusing, laws: MaterialLaws, report: Callable[[str, float], None]
    ) -> "Fields":
        """Take the panel's twin from the cache, or reduce it.

        Parameters
        ----------
        laws : MaterialLaws
            Before the plate's growth.
        report : callable
            Called with the stage's name and the share done.

        Raises
        ------
        ResultFileError
            Where the laws leave the twin's range.
        """
        from app.twins.panel_twin import panel_twin

        laws = panel.plate.grown(laws)
        twin = panel_twin(panel, laws, report)

        def modes(e: float, nu: float, eta: float, count: int) -> tuple[Complex, Real]:
            found = twin.modes(e, nu, eta, count)
            return found.eigenvalues, found.shapes

        return cls(panel, focusing, twin, Shapes(modes, twin.space.deflection, twin.space.grid.points, laws))

    def modes(self, temperature: float) -> tuple[Real, Real, Real]:
        """Natural frequencies, Hz, loss factors and shapes of the lowest modes at a temperature, degrees Celsius.

        Within the band of the twin, outside of which it is not certified; none where there is none.
        """
        f, eta, shapes = self.plate.lowest(temperature, self.plate.deflection.shape[1])
        low, high = self.panel.filters.twin_band
        within = np.flatnonzero((f >= low) & (f <= high))[:MOST_SHAPES]
        return f[within], eta[within], shapes[within]

    def focused(self, temperature: float, frequency: float, *, fixed: bool) -> tuple[float, float, Complex]:
        """Field of the filters at the nearest temperature and line.

        Parameters
        ----------
        temperature : float
            Degrees Celsius.
        frequency : float
            Hz.
        fixed : bool
            Take the filters of the reference temperature at every temperature.

        Returns
        -------
        temperature : float
            The nearest that was computed, degrees Celsius.
        frequency : float
            The nearest line, Hz.
        field : (X, Y) complex ndarray
            Deflection on the grid; NaN off the plate.
        """
        found = self.focusing
        row = int(np.abs(found.temperature - temperature).argmin())
        line = int(np.abs(found.lines - frequency).argmin())
        taken = int(np.abs(found.temperature - found.reference_temperature).argmin()) if fixed else row
        lines, at = found.lines[line : line + 1], float(found.temperature[row])
        amplitude = self.twin.amplitudes(*self.plate.constants(at), lines)[:, 0]
        field = self.plate.deflection @ (found.filters[taken, line] @ amplitude)
        return at, float(lines[0]), self.plate.on_grid(field)


def made_with_corrected_laws(filters: Path) -> bool:
    """Whether the filters were designed with a twin file's laws instead of those of flexura update."""
    with result_file(filters, "focus") as file:
        return "laws.h5" not in read_stamp(file)["inputs"]
