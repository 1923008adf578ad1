"""Mode shapes of the panel and the field its filters make, from the twin that designed them."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from analysis.focusing.over_temperature import Focusing
from analysis.focusing.panel import Panel
from analysis.material import MaterialLaws
from app.files.provenance import read_stamp
from app.panel_twin import PanelTwin, panel_twin

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
MODES = 24
"""Shapes offered."""


@dataclass(frozen=True)
class Fields:
    """What can be animated.

    Attributes
    ----------
    panel : Panel
    focusing : Focusing
    laws : MaterialLaws
    twin : PanelTwin
    """

    panel: Panel
    focusing: Focusing
    laws: MaterialLaws
    twin: PanelTwin

    @classmethod
    def of(
        cls, panel: Panel, focusing: Focusing, laws: MaterialLaws, report: Callable[[str, float], None]
    ) -> "Fields":
        """Take the panel's twin from the cache, or reduce it; ResultFileError where the laws leave its range."""
        return cls(panel, focusing, laws, panel_twin(panel, laws, report))

    @property
    def x(self) -> Real:
        """Points along the plate, (X,), m."""
        return np.unique(self.twin.space.grid.points[:, 0])

    @property
    def y(self) -> Real:
        """Points across the plate, (Y,), m."""
        return np.unique(self.twin.space.grid.points[:, 1])

    def shapes(self, temperature: float) -> tuple[Real, Real, Real]:
        """Natural frequencies (m,), Hz, loss factors (m,) and shapes (m, X, Y) of the lowest elastic modes."""
        modes = self.twin.modes(*self._constants(temperature), count=MODES)
        elastic = modes.eigenvalues.real > (2.0 * np.pi) ** 2  # rigid motion stands below a hertz
        values = modes.eigenvalues[elastic]
        shapes = (self.twin.space.deflection @ modes.shapes[:, elastic]).T
        return np.sqrt(values.real) / (2.0 * np.pi), values.imag / values.real, self._on_grid(shapes)

    def focused(self, temperature: float, frequency: float, *, fixed: bool) -> tuple[float, float, Complex]:
        """Field (X, Y) of the filters at the nearest temperature and line; these two come first.

        `fixed` takes the filters of the reference temperature at every temperature.
        """
        found = self.focusing
        row = int(np.abs(found.temperature - temperature).argmin())
        line = int(np.abs(found.lines - frequency).argmin())
        taken = int(np.abs(found.temperature - found.reference_temperature).argmin()) if fixed else row
        lines = found.lines[line : line + 1]
        amplitude = self.twin.amplitudes(*self._constants(float(found.temperature[row])), lines)[:, 0]
        field = self.twin.space.deflection @ (found.filters[taken, line] @ amplitude)
        return float(found.temperature[row]), float(lines[0]), self._on_grid(field)

    def _constants(self, temperature: float) -> tuple[float, float, float]:
        low, high = self.laws.temperature_range
        law = self.laws.at(np.array([min(max(temperature, low), high)]))
        return float(law.youngs_modulus[0]), float(law.poisson_ratio[0]), float(law.loss_factor[0])

    def _on_grid(self, values: NDArray[Any]) -> NDArray[Any]:
        return values.reshape(*values.shape[:-1], len(self.x), len(self.y))


def made_with_corrected_laws(filters: Path) -> bool:
    """Whether the filters were designed with a twin file's laws instead of those of flexura update."""
    with h5py.File(filters) as file:
        return "laws.h5" not in read_stamp(file)["inputs"]
