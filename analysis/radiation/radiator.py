"""Sound radiated by a plate whose displacement is known at points, each of which stands for a part of its area.

Rayleigh's integral for a plate in an infinite rigid baffle, with the displacement U toward the listener and the
time convention exp(+jωt):

    p(r) = -ω² ρ / Ω  ∫ U exp(-jkR) / R dS,   Ω = 2π,   R the distance from the element to r.

Sources: Rayleigh, Theory of Sound, § 278; F. Fahy, P. Gardonio, Sound and Structural Vibration, 2nd ed., ch. 3;
S. J. Elliott, M. E. Johnson, Radiation modes and the active control of sound power, JASA 94 (1993) 2194-2204.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from analysis.arrays import Complex, Real
from analysis.declaration.strict import Declared

Mounting = Literal["baffle", "box"]
"""A rigid baffle much larger than the wavelength, or a closed box as large as the panel."""

PER_WAVELENGTH = 6.0
"""Cells per wavelength. With fewer, the sum over the cells' midpoints is wrong by more than (π/6)²/6 = 5 %."""
MORE_NODES = 10
"""Interpolation nodes along each side beyond k L / 2. The interpolation of a plane wave by n Chebyshev polynomials
has an error of about the Bessel function J_n(kL/2): 1e-9 or less with these."""
LEAST_LISTENER_HEIGHT = 0.01
"""Smallest height of a listener above the panel, m."""


class Air(Declared):
    """Speed of sound and density, by default those of dry air at 20 °C and 101.325 kPa (ISO 9613-1).

    The ranges contain air from -80 to 120 °C and up to 5 km above the sea.
    """

    sound_speed: Annotated[float, Field(ge=270.0, le=400.0, description="m/s")] = 343.2
    density: Annotated[float, Field(ge=0.4, le=2.0, description="kg/m3")] = 1.204


STANDARD = Air()


@dataclass(frozen=True)
class Radiator:
    """A plate as a set of elemental radiators.

    Attributes
    ----------
    points : (K, 2) ndarray
        m.
    area : (K,) ndarray
        Of the plate about each point, m2.
    air : Air
    mounting : str
        ``baffle``: Rayleigh's integral, exact. ``box``: sources on the face of a small closed box radiate around
        it, into the whole space (Ω = 4π). That holds below `box_limit`; above it, pressure in front of the panel
        is underestimated, by 6 dB at most, because the face then acts as its own baffle.
    """

    points: Real
    area: Real
    air: Air = STANDARD
    mounting: Mounting = "baffle"

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape != (len(self.area), 2) or not len(self.area):
            raise ValueError(f"points {self.points.shape} and area {self.area.shape} must be (K, 2) and (K,)")
        if not (np.isfinite(self.points).all() and (self.area >= 0.0).all() and self.area.sum() > 0.0):
            raise ValueError("points must be finite, areas 0 or more, and their sum above 0")

    @property
    def solid_angle(self) -> float:
        """Ω, into which a small source radiates."""
        return 2.0 * np.pi if self.mounting == "baffle" else 4.0 * np.pi

    @property
    def center(self) -> Real:
        """Centre (2,) of the box around the points, m."""
        return np.asarray(0.5 * (self.points.min(axis=0) + self.points.max(axis=0)))

    @property
    def box_limit(self) -> float:
        """Frequency up to which ``box`` holds, Hz: k times half the panel's diagonal is 1."""
        return float(self.air.sound_speed / (np.pi * np.linalg.norm(np.ptp(self.points, axis=0))))

    @property
    def spacing(self) -> float:
        """Side of a square of the largest cell's area, m."""
        return float(np.sqrt(self.area.max()))

    def wavenumber(self, frequency: Real) -> Real:
        """Wavenumber k (F,) of sound at `frequency` (F,), Hz; 1/m."""
        return np.asarray(2.0 * np.pi * np.asarray(frequency, dtype=float) / self.air.sound_speed)

    def require_fine(self, frequency: float, bending_wavelength: float = np.inf) -> None:
        """Raise ValueError unless the points are close enough at `frequency`, Hz (`require_fine`)."""
        require_fine(self.spacing, frequency, self.air, bending_wavelength)

    def pressure(self, positions: Real, frequency: Real) -> Complex:
        """Pressure per displacement of every point.

        Parameters
        ----------
        positions : (L, 3) ndarray
            Listeners, m, in the panel's coordinates; the third is the height in front of it.
        frequency : (F,) ndarray, Hz

        Returns
        -------
        (L, F, K) complex ndarray
            Pa/m. The pressure of a field U (K,) is its product with U.

        Raises
        ------
        ValueError
            For a listener in or behind the panel.
        """
        positions = np.atleast_2d(np.asarray(positions, dtype=float))
        if (positions[:, 2] < LEAST_LISTENER_HEIGHT).any():
            low = float(positions[:, 2].min())
            raise ValueError(
                f"a listener at z = {low:g} m; allowed: {LEAST_LISTENER_HEIGHT:g} m or more in front of the panel"
            )
        flat = np.linalg.norm(positions[:, None, :2] - self.points, axis=-1)
        distance = np.hypot(flat, positions[:, None, 2])
        phase = np.exp(-1j * self.wavenumber(frequency)[None, :, None] * distance[:, None])
        return np.asarray(self._strength(frequency)[:, None] * phase * (self.area / distance)[:, None])

    def far_field(self, directions: Real, frequency: Real) -> Complex:
        """Pressure far away times the distance, per displacement of every point.

        Parameters
        ----------
        directions : (D, 3) ndarray
            Unit vectors, the third component 0 or more.
        frequency : (F,) ndarray, Hz

        Returns
        -------
        (D, F, K) complex ndarray
            Pa m/m: p r exp(jkr), r measured from `center`.
        """
        path = directions[:, :2] @ (self.points - self.center).T
        phase = np.exp(1j * self.wavenumber(frequency)[None, :, None] * path[:, None])
        return np.asarray(self._strength(frequency)[:, None] * phase * self.area)

    def sources(self, highest: float) -> "SourceNodes":
        """Few equivalent sources that radiate the same power up to the frequency `highest`, Hz."""
        return SourceNodes.of(self, highest)

    def _strength(self, frequency: Real) -> Real:
        """-ω² ρ / Ω (F,)."""
        omega = 2.0 * np.pi * np.asarray(frequency, dtype=float)
        return np.asarray(-(omega**2) * self.air.density / self.solid_angle)


def require_fine(spacing: float, frequency: float, air: Air, bending_wavelength: float = np.inf) -> None:
    """Check that points are close enough for Rayleigh's integral.

    Parameters
    ----------
    spacing : float
        Side of a square of the largest cell's area, m.
    frequency : float
        Highest one, Hz.
    bending_wavelength : float
        Of the plate at this frequency, m.

    Raises
    ------
    ValueError
        Where the cells are larger than a sixth of the wavelength of sound, or of the plate.
    """
    waves = {"of sound": air.sound_speed / frequency, "of the plate": bending_wavelength}
    name, wave = min(waves.items(), key=lambda item: item[1])
    allowed = wave / PER_WAVELENGTH
    if spacing > allowed * (1.0 + 1e-9):
        raise ValueError(
            f"points {1e3 * spacing:.3g} mm apart are too coarse for {frequency:g} Hz, where the wavelength "
            f"{name} is {1e3 * wave:.3g} mm: allowed is a sixth of it, {1e3 * allowed:.3g} mm. Take more points, "
            "or a band that ends lower"
        )


@dataclass(frozen=True)
class SourceNodes:
    """Equivalent sources at Chebyshev nodes of the box around a radiator.

    Attributes
    ----------
    radiator : Radiator
    nodes : (m, 2) ndarray
        m.
    lumped : (m, K) ndarray
        Volume displacement at each node per displacement of every point, m2.

    Notes
    -----
    The power of a plate is

        W = ω⁴ρ/(2Ωc) ∬ U*(x) sin(kR)/(kR) U(x') dS dS',   R = |x - x'|.

    The kernel is smooth, so that its interpolation between a few nodes is exact to rounding: the K points are
    replaced by m nodes with the volume displacements ∫ ℓ_i U dS, ℓ_i the Lagrange polynomials of the nodes.
    """

    radiator: Radiator
    nodes: Real
    lumped: Real

    @classmethod
    def of(cls, radiator: Radiator, highest: float) -> "SourceNodes":
        """Place nodes for frequencies up to `highest`, Hz."""
        points, k = radiator.points, float(radiator.wavenumber(np.array([highest]))[0])
        low, high = points.min(axis=0), points.max(axis=0)
        axes, weights = [], []
        for axis in range(2):
            half = max(0.5 * float(high[axis] - low[axis]), 1e-6)
            count = int(np.ceil(1.2 * k * half)) + MORE_NODES
            place = np.cos(np.pi * (np.arange(count) + 0.5) / count)
            vander = np.polynomial.chebyshev.chebvander
            relative = (points[:, axis] - radiator.center[axis]) / half
            weights.append(vander(relative, count - 1) @ np.linalg.inv(vander(place, count - 1)))
            axes.append(radiator.center[axis] + half * place)
        nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        each = (weights[0][:, :, None] * weights[1][:, None, :]).reshape(len(points), -1)
        return cls(radiator, nodes, (radiator.area[:, None] * each).T)

    @cached_property
    def _apart(self) -> Real:
        """Distances (m, m) between the nodes, m."""
        return np.asarray(np.linalg.norm(self.nodes[:, None] - self.nodes, axis=-1))

    def resistance(self, frequency: float) -> Real:
        """Matrix R (m, m) of one frequency, Hz: the power of volume displacements q (m,) is qᴴ R q, W/m6."""
        air, omega = self.radiator.air, 2.0 * np.pi * frequency
        k = omega / air.sound_speed
        scale = omega**4 * air.density / (2.0 * self.radiator.solid_angle * air.sound_speed)
        return np.asarray(scale * np.sinc(k * self._apart / np.pi))

    def power(self, fields: Complex, frequency: Real, regions: Real | None = None) -> Complex:
        """Radiated power of N fields as Hermitian forms.

        Parameters
        ----------
        fields : (F, K, N) ndarray
            Displacements at the points, per unit of each of N drives.
        frequency : (F,) ndarray, Hz
        regions : (K,) ndarray, optional
            Share of each point's area that belongs to a region: the form is then that of the power of the region
            in the sound of all. The mutual power of two elements is divided equally between them, so that the
            powers of region and rest add up to the whole; one of them may be negative.

        Returns
        -------
        (F, N, N) complex ndarray
            Hermitian. The power of drives a is aᴴ form a, W, for amplitudes (not root mean squares) a.
        """
        lumped = self.lumped if regions is None else self.lumped * regions
        found = []
        for here, field in zip(np.asarray(frequency, dtype=float), fields, strict=True):
            whole, part = self.lumped @ field, lumped @ field
            form = part.conj().T @ (self.resistance(float(here)) @ whole)
            found.append(0.5 * (form + form.conj().T))
        return np.array(found)
