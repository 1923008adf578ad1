"""Protocol of a computed panel: fields, energies and modes."""

from dataclasses import dataclass
from typing import Protocol

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_finite, check_shapes
from analysis.focusing.energy import EnergyForms, FieldSpace

Constants = tuple[float, float, float]
"""E, Pa, nu and eta."""


@dataclass(frozen=True)
class PanelModes:
    """Natural modes of a panel, mass-normalised, in the twin's generalised coordinates.

    Attributes
    ----------
    eigenvalues : (m,) ndarray
        Complex ω²(1 + jη), ascending, rad2/s2.
    shapes : (r, m) ndarray
    coupling : (m, N) ndarray
        Modal force of every actuator, N/V or N/N.
    """

    eigenvalues: Complex
    shapes: Real
    coupling: Real

    def __post_init__(self) -> None:
        check_shapes(self, eigenvalues="m", shapes="r m", coupling="m N")
        check_finite(self, "eigenvalues", "shapes", "coupling")


class PanelModel(Protocol):
    """A panel that can be computed: the interface through which `analysis` uses the twin."""

    @property
    def space(self) -> FieldSpace:
        """The deflection shapes on the panel's grid, with their inner products."""

    def amplitudes(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: Real
    ) -> Complex:
        """Generalised coordinates of the field of every actuator.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) ndarray, Hz

        Returns
        -------
        (N, F, r) complex ndarray
            Per volt or newton.

        Raises
        ------
        ValueError
            For a material outside the box of the model.
        """

    def forms(
        self,
        youngs_modulus: float,
        poisson_ratio: float,
        loss_factor: float,
        frequency: Real,
        displacement: float = 1.0,
    ) -> EnergyForms:
        """Energy forms of these fields, computed without the fields where that is faster.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) ndarray, Hz
        displacement : float
            Desired displacement of the target, m per unit of audio signal.

        Returns
        -------
        EnergyForms
            Of one material.

        Raises
        ------
        ValueError
            For a material outside the box of the model.
        """

    def restricted(self, basis: Real) -> "PanelModel":
        """Return the same panel reduced to the orthonormal columns of `basis` (r, s)."""

    def modes(self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, count: int) -> PanelModes:
        """Return the lowest `count` modes.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        """


@dataclass(frozen=True)
class NoModes:
    """A panel of which only the fields are known: enough for STIF, time reversal and no control."""

    space: FieldSpace

    def amplitudes(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: Real
    ) -> Complex:
        """Raise ValueError: the fields at another material are not known.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) ndarray, Hz

        Returns
        -------
        (N, F, r) complex ndarray
            Never reached.

        Raises
        ------
        ValueError
            Always.
        """
        raise ValueError("measured transfers hold for the plate that was measured only")

    def forms(
        self,
        youngs_modulus: float,
        poisson_ratio: float,
        loss_factor: float,
        frequency: Real,
        displacement: float = 1.0,
    ) -> EnergyForms:
        """Raise ValueError, as `amplitudes` does.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) ndarray, Hz
        displacement : float
            Desired displacement of the target, m per unit of audio signal.

        Returns
        -------
        EnergyForms
            Never reached.

        Raises
        ------
        ValueError
            Always.
        """
        raise ValueError("measured transfers hold for the plate that was measured only")

    def restricted(self, basis: Real) -> PanelModel:
        """Raise ValueError: there are no coordinates to restrict to `basis` (r, s)."""
        raise ValueError("measured transfers have no coordinates")

    def modes(self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, count: int) -> PanelModes:
        """Raise ValueError: there is no model.

        Parameters
        ----------
        youngs_modulus : float
            Pa.

        Returns
        -------
        PanelModes
            Never reached.

        Raises
        ------
        ValueError
            Always.
        """
        raise ValueError("measured transfers have no modes")
