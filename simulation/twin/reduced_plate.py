"""Protocol of a reduced plate for the twin: its matrices in any supported state."""

from typing import Protocol

from analysis.arrays import Real
from analysis.material import MaterialBox
from simulation.reduction.composition import Composite
from simulation.state.attached import Attachable
from simulation.state.plate_state import PlateState


class CompositeSlopes(Protocol):
    """Derivatives of a composite in some local coordinates."""

    def by(self, stepped: PlateState) -> Composite:
        """Differentiate by the parameter whose imaginary step of `COMPLEX_STEP` gave `stepped`."""
        ...

    def by_along_moves(self, stepped: PlateState) -> Composite:
        """Differentiate likewise what the moves of patches change."""
        ...


class LoadedPlate(Attachable, Protocol):
    """Loads and dampers of a reduced plate of r coordinates, besides its stiffness and its patches."""

    @property
    def band(self) -> tuple[float, float]:
        """Hz."""
        ...

    @property
    def damping(self) -> Real:
        """Of the supports' dashpots, (r, r), N s/m."""
        ...

    @property
    def normal(self) -> Real:
        """Integral of w times w, (r, r), m2."""
        ...

    @property
    def points(self) -> Real:
        """Where point loads can act, (K, 2), m."""
        ...

    @property
    def deflection(self) -> Real:
        """Deflection w there, (K, r)."""
        ...

    @property
    def deflection_slopes(self) -> Real:
        """Derivatives of `deflection` by shifts along x and y, (2, K, r), 1/m."""
        ...


class ReducedPlate(LoadedPlate, Protocol):
    """A plate with P patches and S footprints of transducers over r coordinates."""

    @property
    def box(self) -> MaterialBox:
        """Certified materials."""
        ...

    @property
    def error(self) -> float:
        """Certified error of a transfer."""
        ...

    @property
    def capacitance(self) -> Real:
        """Of the patches, (P,), F."""
        ...

    @property
    def footprints(self) -> Real:
        """Mean deflection over each, (S, r)."""
        ...

    @property
    def footprint_slopes(self) -> Real:
        """Derivatives of `footprints` by shifts along x and y, 1/m, and by a share of their area, (3, S, r)."""
        ...

    def require(self, state: PlateState) -> None:
        """ValueError, naming value and range, for a state that is not supported or not certified."""
        ...

    def composed(self, state: PlateState) -> Composite:
        """Return the matrices of a state, with the patches as ports."""
        ...

    def slopes(self, state: PlateState, basis: Real) -> CompositeSlopes:
        """Return derivatives of `composed` at a state, in the local coordinates that are columns of `basis`."""
        ...
