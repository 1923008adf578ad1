"""What is asked of a panel that can be computed: its fields, their energies, its modes."""

from dataclasses import dataclass
from typing import Protocol

from analysis.arrays import Complex, Real
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


class PanelModel(Protocol):
    """A panel that can be computed: what `analysis` sees of the twin."""

    @property
    def space(self) -> FieldSpace:
        """The deflection shapes, measured over the panel's grid."""

    def amplitudes(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: Real
    ) -> Complex:
        """Generalised coordinates of the field of every actuator.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        poisson_ratio : float
        loss_factor : float
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
        """Energy forms of these fields, without the fields where that is quicker.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        poisson_ratio : float
        loss_factor : float
        frequency : (F,) ndarray, Hz
        displacement : float
            What the target is asked for, m per unit of audio signal.

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
        """Return the same panel on the columns of `basis` (r, s), orthonormal."""

    def modes(self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, count: int) -> PanelModes:
        """Return the lowest `count` modes.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        poisson_ratio : float
        loss_factor : float
        count : int

        Returns
        -------
        PanelModes
        """


@dataclass(frozen=True)
class NoModes:
    """A panel known by its fields alone: enough for STIF, time reversal and no control."""

    space: FieldSpace

    def amplitudes(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: Real
    ) -> Complex:
        """Refuse: nothing is known of another material.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        poisson_ratio : float
        loss_factor : float
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
        """Refuse, as `amplitudes` does.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        poisson_ratio : float
        loss_factor : float
        frequency : (F,) ndarray, Hz
        displacement : float
            What the target is asked for, m per unit of audio signal.

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
        """Refuse: there are no coordinates to restrict to `basis` (r, s); ValueError always."""
        raise ValueError("measured transfers have no coordinates")

    def modes(self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, count: int) -> PanelModes:
        """Refuse: there is no model.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        poisson_ratio : float
        loss_factor : float
        count : int

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
