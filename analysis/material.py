"""Elastic constants of a hysteretically damped plate, and their laws over temperature.

E, nu and eta as functions of temperature near one temperature; by how much a sheet departs from isotropy.
"""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.checked_fields import check_ascending, check_finite, check_range, check_shapes


@dataclass(frozen=True)
class Orthotropy:
    """Departure of a sheet from isotropy, referred to its own axes.

    E = (E_x + E_y) / 2, E_x = E(1 - delta_e), E_y = E(1 + delta_e), nu_xy nu_yx = nu**2, in-plane shear modulus
    (1 + delta_g) E / 2(1 + nu), transverse shear moduli E / 2(1 + nu) times `transverse`.

    Attributes
    ----------
    delta_e, delta_g : float
    angle : float
        Of the sheet's x axis against the plate's, rad, towards y.
    transverse : (float, float)
        Of the planes xz and yz.
    declared_transverse : bool
        Whether these were declared; else they are those of the shear in the plane.
    """

    delta_e: float
    delta_g: float
    angle: float = 0.0
    transverse: tuple[float, float] = (1.0, 1.0)
    declared_transverse: bool = False

    def __post_init__(self) -> None:
        if not (abs(self.delta_e) < 1.0 and self.delta_g > -1.0 and min(self.transverse) > 0.0):
            raise ValueError(
                f"orthotropy: delta_e {self.delta_e:g}, delta_g {self.delta_g:g}, transverse {self.transverse}: "
                "|delta_e| must be below 1, delta_g above -1 and the transverse shear above 0"
            )

    @property
    def ratio(self) -> float:
        """E_y / E_x."""
        return (1.0 + self.delta_e) / (1.0 - self.delta_e)


@dataclass(frozen=True)
class LocalLaws:
    """Second-order expansions of log E, nu and log eta about a reference temperature.

    A plate with gradients of a few kelvins, or one that lags behind its oven, is described by what its laws do
    within those kelvins. All methods accept complex temperatures, for derivatives by complex step.

    Attributes
    ----------
    reference : float
        Degrees Celsius.
    value, slope, curvature : (3,) ndarray
        Of log E [log Pa], nu and log eta: at `reference`, per K and per K2.
    """

    reference: float
    value: NDArray[np.float64]
    slope: NDArray[np.float64]
    curvature: NDArray[np.float64]

    def __post_init__(self) -> None:
        for name in ("value", "slope", "curvature"):
            row = getattr(self, name)
            if row.shape != (3,) or not np.isfinite(row).all():
                raise ValueError(f"local laws: {name} is {row}; three finite numbers wanted")

    @classmethod
    def of_material(
        cls,
        youngs_modulus: float,
        poisson_ratio: float,
        loss_factor: float,
        *,
        reference: float = 20.0,
        slope: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> "LocalLaws":
        """Laws through one material, linear in temperature.

        Parameters
        ----------
        youngs_modulus : float
            At `reference`, Pa.
        poisson_ratio : float
            At `reference`.
        loss_factor : float
            At `reference`.
        reference : float
            °C.
        slope : (float, float, float)
            Of log E, nu and log eta, per K.

        Returns
        -------
        LocalLaws
            Without curvature.
        """
        value = np.array([np.log(youngs_modulus), poisson_ratio, np.log(loss_factor)])
        return cls(reference, value, np.array(slope), np.zeros(3))

    def tilted(
        self, slope: NDArray[np.float64], curvature: NDArray[np.float64], temperature: float
    ) -> "LocalLaws":
        """Add a slope and a curvature, turning and bending the laws about a temperature.

        Parameters
        ----------
        slope, curvature : (3,) ndarray
            Per K and per K2.
        temperature : float
            Where values stay, and slopes change by `slope` alone, degrees Celsius.
        """
        away = temperature - self.reference
        return replace(
            self,
            value=self.value - away * (slope - 0.5 * away * curvature),
            slope=self.slope + slope - away * curvature,
            curvature=self.curvature + curvature,
        )

    def grown(self, expansion: float, dimensions_at: float) -> "LocalLaws":
        """Laws of a plate that keeps its dimensions and is as stiff as this one, which grows with temperature.

        A bare plate of constant mass that grows alike in all directions, to g = 1 + expansion (T - dimensions_at)
        times its dimensions, has g times the stiffness: bending E h**3 / L**2, membrane and shear E h all go with
        g, once rotations are counted in units of 1/g.

        Parameters
        ----------
        expansion : float
            Coefficient of thermal expansion, 1/K.
        dimensions_at : float
            Temperature at which the declared dimensions hold, degrees Celsius.
        """
        growth = 1.0 + expansion * (self.reference - dimensions_at)
        of_log = np.array([np.log(growth), expansion / growth, -((expansion / growth) ** 2)])
        by_e = np.array([1.0, 0.0, 0.0])
        return replace(
            self,
            value=self.value + of_log[0] * by_e,
            slope=self.slope + of_log[1] * by_e,
            curvature=self.curvature + of_log[2] * by_e,
        )

    def youngs_modulus(self, temperature: Any) -> Any:
        """E at `temperature` [degrees Celsius], Pa."""
        return np.exp(self._at(0, temperature))

    def poisson_ratio(self, temperature: Any) -> Any:
        """Poisson's ratio at `temperature` [degrees Celsius]."""
        return self._at(1, temperature)

    def loss_factor(self, temperature: Any) -> Any:
        """Loss factor at `temperature` [degrees Celsius]."""
        return np.exp(self._at(2, temperature))

    def rates(self, temperature: float) -> NDArray[np.float64]:
        """How log E, nu and log eta change at `temperature` [degrees Celsius], (3,), per K."""
        rates: NDArray[np.float64] = self.slope + self.curvature * (temperature - self.reference)
        return rates

    def _at(self, law: int, temperature: Any) -> Any:
        away = np.asarray(temperature) - self.reference
        return self.value[law] + away * (self.slope[law] + 0.5 * away * self.curvature[law])


LARGEST_LOSS_FACTOR = 10.0
"""No material of a plate reaches 2; more than this is a damping in per cent, or a fit that ran away."""


@dataclass(frozen=True)
class Material:
    """E, nu and eta at one or more temperatures: complex modulus E(1 + j eta), real nu.

    Attributes
    ----------
    youngs_modulus : (T,) ndarray
        Pa.
    poisson_ratio : (T,) ndarray
        Up to 1: of an orthotropic sheet the root of nu_xy nu_yx, which no isotropic bound holds below 0.5.
    loss_factor : (T,) ndarray
    """

    youngs_modulus: NDArray[np.float64]
    poisson_ratio: NDArray[np.float64]
    loss_factor: NDArray[np.float64]

    def __post_init__(self) -> None:
        check_shapes(self, youngs_modulus="T", poisson_ratio="T", loss_factor="T")
        check_finite(self, "youngs_modulus")
        check_range(self, 0.0, np.inf, "youngs_modulus", unit="Pa", above=True)
        check_range(self, -1.0, 1.0, "poisson_ratio")
        check_range(self, 0.0, LARGEST_LOSS_FACTOR, "loss_factor")

    def sigma(self, laws: NDArray[np.float64]) -> "MaterialSigma":
        """Return the standard deviations of E [Pa], nu and eta from those (T, 3) of log E, nu and log eta."""
        return MaterialSigma(laws[:, 0] * self.youngs_modulus, laws[:, 1], laws[:, 2] * self.loss_factor)


@dataclass(frozen=True)
class MaterialSigma:
    """Standard deviations of a `Material`, in the constants' units.

    Attributes
    ----------
    youngs_modulus, poisson_ratio, loss_factor : (T,) ndarray
        NaN or infinite where a sweep that did not settle tells nothing.
    """

    youngs_modulus: NDArray[np.float64]
    poisson_ratio: NDArray[np.float64]
    loss_factor: NDArray[np.float64]

    def __post_init__(self) -> None:
        check_shapes(self, youngs_modulus="T", poisson_ratio="T", loss_factor="T")
        for field in fields(self):
            if (getattr(self, field.name) < 0.0).any():
                raise ValueError(f"MaterialSigma.{field.name} is negative; allowed: from 0")


@dataclass(frozen=True)
class MaterialBox:
    """The range of E [Pa], nu and eta over which a twin's accuracy is certified, as (low, high) pairs."""

    youngs_modulus: tuple[float, float]
    poisson_ratio: tuple[float, float]
    loss_factor: tuple[float, float]

    def __post_init__(self) -> None:
        for name, unit in (("youngs_modulus", "Pa"), ("poisson_ratio", ""), ("loss_factor", "")):
            check_finite(self, name)
            check_range(self, 0.0, np.inf, name, unit=unit, above=name == "youngs_modulus")
            check_ascending(self, name, equal=True)
        check_range(self, 0.0, 1.0, "poisson_ratio", "loss_factor")

    def clip(self, material: NDArray[np.float64]) -> NDArray[np.float64]:
        """Move (..., 3) values of E, nu, eta to the nearest values inside."""
        clipped: NDArray[np.float64] = np.clip(material, self._bounds[:, 0], self._bounds[:, 1])
        return clipped

    def inside(self, material: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which of (..., 3) values of E, nu, eta lie inside, a wall not being inside."""
        low, high = self._bounds.T
        within: NDArray[np.bool_] = ((material > low) & (material < high)).all(-1)
        return within

    def require(self, youngs_modulus: float, poisson_ratio: float, loss_factor: float) -> None:
        """Refuse a material that lies outside.

        Parameters
        ----------
        youngs_modulus : float
            Pa.

        Raises
        ------
        ValueError
            With the value seen and the range allowed.
        """
        asked = (
            ("youngs_modulus", youngs_modulus, self.youngs_modulus, "Pa"),
            ("poisson_ratio", poisson_ratio, self.poisson_ratio, ""),
            ("loss_factor", loss_factor, self.loss_factor, ""),
        )
        for name, value, (low, high), unit in asked:
            slack = 1e-9 * high
            if not low - slack <= value <= high + slack:
                raise ValueError(
                    f"{name} {value:.6g} {unit} is outside the twin's box, {low:.6g} to {high:.6g} {unit}"
                )

    @property
    def _bounds(self) -> NDArray[np.float64]:
        return np.array([self.youngs_modulus, self.poisson_ratio, self.loss_factor])


@dataclass(frozen=True)
class MaterialLaws:
    """Smooth E(T), nu(T), eta(T) with one-standard-deviation bands, valid over a stated range.

    Cubic splines of log E, nu and log eta on common knots; `covariance` is that of the coefficients.
    `analysis.updating.laws` makes them from estimates at single temperatures.

    Attributes
    ----------
    knots : (n + 4,) ndarray
        Knots of the cubic splines, degrees Celsius.
    coefficients : (3, n) ndarray
        Of log E [log Pa], nu and log eta.
    covariance : (3, n, n) ndarray
        Of each law's coefficients.
    temperature_range : (float, float)
        Where the laws hold, degrees Celsius.
    """

    knots: NDArray[np.float64]
    coefficients: NDArray[np.float64]
    covariance: NDArray[np.float64]
    temperature_range: tuple[float, float]

    def __post_init__(self) -> None:
        check_shapes(self, coefficients="3 n", covariance="3 n n", knots="n+4", temperature_range="2")
        check_finite(self, "knots", "coefficients", "covariance", "temperature_range")
        check_ascending(self, "knots", "temperature_range", equal=True)

    def at(self, temperature: ArrayLike) -> Material:
        """Constants at `temperature` (T,), degrees Celsius; ValueError outside the range."""
        e, nu, eta = self._values(temperature)
        return Material(np.exp(e), nu, np.exp(eta))

    def sigma(self, temperature: ArrayLike) -> MaterialSigma:
        """One standard deviation of each constant at `temperature` (T,), in the constant's unit."""
        design = self._design(temperature)
        spread = np.sqrt(np.einsum("tn,pnm,tm->pt", design, self.covariance, design))
        value = self.at(temperature)
        return MaterialSigma(spread[0] * value.youngs_modulus, spread[1], spread[2] * value.loss_factor)

    def scaled(self, temperature: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Log E, nu and log eta (3, T) at `temperature` (T,), and the covariance (3, T, T) of each."""
        design = self._design(temperature)
        return self.coefficients @ design.T, np.einsum("tn,pnm,sm->pts", design, self.covariance, design)

    def local(self, temperature: float) -> LocalLaws:
        """Expand the laws to second order about `temperature`, degrees Celsius; ValueError outside the range."""
        from scipy.interpolate import BSpline

        value = self._values(temperature)[:, 0]
        at = float(np.clip(temperature, *self.temperature_range))
        spline = BSpline(self.knots, self.coefficients.T, 3)
        slope, curvature = (np.asarray(spline.derivative(order)(at)) for order in (1, 2))
        return LocalLaws(float(temperature), value, slope, curvature)

    def grown(self, expansion: float, dimensions_at: float) -> "MaterialLaws":
        """Laws with E times the growth of a plate's dimensions, see `LocalLaws.grown`."""
        greville = (self.knots[1:-3] + self.knots[2:-2] + self.knots[3:-1]) / 3.0  # there straight lines are exact
        coefficients = self.coefficients.copy()
        coefficients[0] += np.log(1.0 + expansion * (greville - dimensions_at))
        return replace(self, coefficients=coefficients)

    def _values(self, temperature: ArrayLike) -> NDArray[np.float64]:
        values: NDArray[np.float64] = self.coefficients @ self._design(temperature).T
        return values

    def _design(self, temperature: ArrayLike) -> NDArray[np.float64]:
        from scipy.interpolate import BSpline

        t = np.atleast_1d(np.asarray(temperature, dtype=float))
        low, high = self.temperature_range
        outside = t[(t < low - 1e-9) | (t > high + 1e-9)]
        if outside.size:
            raise ValueError(
                f"temperature {outside[0]:g} °C is outside the laws' range, {low:g} to {high:g} °C: "
                "laws are not extrapolated"
            )
        design: NDArray[np.float64] = BSpline.design_matrix(np.clip(t, low, high), self.knots, 3).toarray()
        return design


def laws_through(temperature: NDArray[np.float64], material: Material) -> MaterialLaws:
    """Return laws that pass through values at `temperature` exactly, and claim no uncertainty.

    Cubic splines of log E, nu and log eta without a knot at the second and the last but one value.

    Parameters
    ----------
    temperature : (T,) ndarray
        Ascending, degrees Celsius; at least 4.
    material : Material
        (T,) arrays.

    Raises
    ------
    ValueError
        For fewer than four temperatures, or such as do not ascend.
    """
    from scipy.interpolate import make_interp_spline

    if temperature.size < 4 or not (np.diff(temperature) > 0.0).all():
        raise ValueError(f"{temperature.size} temperatures, which must ascend; at least 4 make a law")
    curves = (np.log(material.youngs_modulus), material.poisson_ratio, np.log(material.loss_factor))
    splines = [make_interp_spline(temperature, curve, k=3) for curve in curves]
    coefficients = np.array([spline.c for spline in splines], dtype=np.float64)
    return MaterialLaws(
        knots=np.asarray(splines[0].t, dtype=np.float64),
        coefficients=coefficients,
        covariance=np.zeros((3, coefficients.shape[1], coefficients.shape[1])),
        temperature_range=(float(temperature[0]), float(temperature[-1])),
    )
