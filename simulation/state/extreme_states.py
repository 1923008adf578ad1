"""States at the limits of the effects on a plate, for the training of reduced models."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.declaration.plate_material import Orthotropy
from analysis.local_laws import LocalLaws
from analysis.material import MaterialBox
from simulation.state.departures import Departures, Sheet, departed_moduli, departed_transverse
from simulation.state.plate_state import PlateState

STEEPEST_SLOPES = (-0.025, 0.0025, -0.01)
"""Steepest slopes of log E, nu and log eta of polypropylene, 1/K."""

SOFT, STIFF = (0.2, 0.68), (0.82, 0.26)
"""Shares of a box's ranges of E (geometric) and nu: soft, with most modes in the band, and stiff."""

ANISOTROPY, TAPER, TILT, SLIP, SHEARED = 0.12, 0.05, 3.5, 0.45, 0.4
"""Changes of moduli, thickness and temperature [K] towards an edge, of the bond, and of the
transverse shear modulus."""


def laws_within(box: MaterialBox, shares: tuple[float, float], loss_factor: float = 0.05) -> LocalLaws:
    """Return a material at given shares of a box's ranges, steep in temperature, its loss within the box.

    Parameters
    ----------
    shares : (float, float)
        0 to 1, of the ranges of log E and nu.
    loss_factor : float
        Clipped to the box's range.
    """
    (e0, e1), (n0, n1), (h0, h1) = box.youngs_modulus, box.poisson_ratio, box.loss_factor
    e, nu = e0 * (e1 / e0) ** shares[0], n0 + shares[1] * (n1 - n0)
    return LocalLaws.of_material(float(e), float(nu), float(np.clip(loss_factor, h0, h1)), slope=STEEPEST_SLOPES)


def extreme_states(
    xi: NDArray[Any], zeta: NDArray[Any], laws: LocalLaws, offset_range: float, size: float = 1.0
) -> list[PlateState]:
    """One state for each kind of change of fields and patches.

    Parameters
    ----------
    xi, zeta : (Q,) ndarray
        Sampling points of the fields, -1 to 1.
    offset_range : float
        Farthest shift of the first sensor patch, m.
    size : float
        Share of the certified range, negative for the other side.
    """
    plain = PlateState.baseline(xi, zeta, laws, laws.reference, np.array([500.0]))
    return [
        plain.with_(
            modulus_x=1 - ANISOTROPY * size, modulus_y=1 + ANISOTROPY * size, in_plane_shear=1 + ANISOTROPY * size
        ),
        plain.with_(in_plane_shear=1 - ANISOTROPY * size),
        plain.with_(thickness=1.0 + TAPER * size * xi),
        plain.with_(thickness=1.0 + TAPER * size * zeta),
        plain.with_(temperature=laws.reference + TILT * size * xi),
        plain.with_(temperature=laws.reference + TILT * size * zeta),
        plain.with_(bond=1.0 - SLIP * abs(size)),
        plain.with_(transverse_shear=1.0 - SHEARED * size),
        *offset_states(plain, size * offset_range),
    ]


def offset_states(plain: PlateState, offset: float) -> list[PlateState]:
    """States with the sensor offset along x, and along y; none if the offset is zero."""
    return [plain.with_(offset_x=offset), plain.with_(offset_y=offset)] if offset else []


def combined_state(
    xi: NDArray[Any], zeta: NDArray[Any], laws: LocalLaws, offset_range: float, size: float
) -> PlateState:
    """All of `extreme_states` at once; 0 is the plate as declared.

    Parameters
    ----------
    xi, zeta : (Q,) ndarray
        Sampling points of the fields, -1 to 1.
    offset_range : float
        Farthest shift of the first sensor patch, m.
    size : float
        Share of the certified range, negative for the other side.
    """
    plain = PlateState.baseline(xi, zeta, laws, laws.reference, np.array([500.0]))
    return plain.with_(
        modulus_x=1 - ANISOTROPY * size,
        modulus_y=1 + ANISOTROPY * size,
        in_plane_shear=1 + ANISOTROPY * size,
        thickness=1.0 + TAPER * size * (xi - zeta),
        temperature=laws.reference + TILT * size * (xi + zeta),
        bond=1.0 - SLIP * abs(size),
        transverse_shear=1.0 - SHEARED * size,
        offset_x=size * offset_range,
        offset_y=-size * offset_range,
    )


def departed_sheet(state: PlateState, sheet: Orthotropy, away: Sheet) -> PlateState:
    """Return the state of a sheet with other moduli than declared.

    Parameters
    ----------
    state : PlateState
        Without departures.
    sheet : Orthotropy
        As declared.
    away : (4,) tuple of float
        Logarithms, see `simulation.state.departures`.
    """
    ratio, shear, *across = away
    factors = departed_moduli(sheet, ratio, shear)
    factors |= {name: factors[name] * one for name, one in departed_transverse(*across).items()}
    return state.with_(departures=Departures(**factors))
