"""Fields from a run's twin: mode shapes at any temperature of its laws, and the field that filters make."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.focusing.over_temperature import Focusing
from analysis.focusing.panel import Panel
from analysis.material import MaterialLaws
from app.files.hdf5_file import result_file
from app.files.provenance import read_stamp

if TYPE_CHECKING:
    from app.twins.panel_twin import PanelTwin


MOST_SHAPES = 24
"""Shapes offered at most."""


LARGEST_RIGID_FREQUENCY = 1.0
"""Hz; rigid motion stands below."""
LEAST_DEFLECTION = 0.02
"""Share of the largest mode's rms deflection, below which a mode is no bending: the rotation of a free plate
within its plane is none, patches do not drive it, and a twin made for them puts it at tens of hertz."""


@dataclass(frozen=True)
class Shapes:
    """A plate that can be asked for its shapes.

    Attributes
    ----------
    modes : callable
        E [Pa], nu, eta and a count to squared angular frequencies (m,), complex, rad2/s2, and shapes (r, m).
    deflection : (K, r) ndarray
        Of every coordinate at `points`.
    points : (K, 2) ndarray
        Points of a grid that lie on the plate, x slowest, m.
    laws : MaterialLaws
    """

    modes: Callable[[float, float, float, int], tuple[Complex, Real]]
    deflection: Real
    points: Real
    laws: MaterialLaws

    @property
    def x(self) -> Real:
        """Points along the plate, (X,), m."""
        return np.unique(self.points[:, 0])

    @property
    def y(self) -> Real:
        """Points across the plate, (Y,), m."""
        return np.unique(self.points[:, 1])

    def constants(self, temperature: float) -> tuple[float, float, float]:
        """E [Pa], nu and eta at a temperature, or at the nearest end of the laws."""
        low, high = self.laws.temperature_range
        law = self.laws.at(np.array([min(max(temperature, low), high)]))
        return float(law.youngs_modulus[0]), float(law.poisson_ratio[0]), float(law.loss_factor[0])

    def lowest(self, temperature: float, count: int) -> tuple[Real, Real, Real]:
        """Natural frequencies (m,), Hz, loss factors (m,) and shapes (m, X, Y) of the lowest bending modes.

        `count` of them, less those of rigid motion.
        """
        values, shapes = self.modes(*self.constants(temperature), count)
        found = (self.deflection @ shapes).T
        level = np.linalg.norm(found, axis=1)
        bending = (values.real > (2.0 * np.pi * LARGEST_RIGID_FREQUENCY) ** 2) & (
            level > LEAST_DEFLECTION * level.max()
        )
        values = values[bending]
        return np.sqrt(values.real) / (2.0 * np.pi), values.imag / values.real, self.on_grid(found[bending])

    def on_grid(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values at the points (..., K) as (..., X, Y); NaN off the plate."""
        found = np.full((*values.shape[:-1], len(self.x), len(self.y)), np.nan, values.dtype)
        row, column = (np.searchsorted(at, self.points[:, k]) for k, at in enumerate((self.x, self.y)))
        found[..., row, column] = values
        return found


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
