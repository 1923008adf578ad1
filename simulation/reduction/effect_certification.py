"""Error of a reduced plate with effects, measured against the full one in states outside the training set.

States at the limits of the effects on a plate, for the training of reduced models.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.channel import Footprint
from analysis.material import LocalLaws, MaterialBox, Orthotropy
from simulation.reduction.composition import Coefficients, composed
from simulation.reduction.effect_operators import BENDING_DEGREE, EffectOperators
from simulation.shell.unknowns import factorize
from simulation.state.field_basis import field_basis
from simulation.state.plate_state import (
    CERTIFIED,
    CERTIFIED_NEAR,
    Departures,
    PlateState,
    Sheet,
    departed_moduli,
    departed_transverse,
)
from simulation.state.state_matrices import FullPlate
from simulation.twin.local_solution import LocalSolution

STATES = (((0.25, 0.79), 0.0), ((0.82, 0.26), -0.5))
"""Shares of the box's ranges of E and nu, and size of the effects: soft without effects, stiff with all."""
CERTIFIED_LINES = 200
"""Number of evenly spaced lines in the band."""


def measured_error(full: FullPlate, ops: EffectOperators, footprints: Sequence[Footprint] = ()) -> float:
    """Largest error of any transfer between patches and footprints, over its peak along the band.

    For a soft plate as declared, and a stiff one with all effects at once, half as strong as in `extreme_states`
    and of opposite sign; at the line where the reduced transfers are largest and at a random line.

    Parameters
    ----------
    footprints : sequence of Footprint
        The first of `EffectOperators.forces`.

    Raises
    ------
    ValueError
        Where there is no space for the sensor's offset.
    """
    rng = np.random.default_rng(0)
    basis = field_basis(BENDING_DEGREE)
    drawn = [int(line) for line in rng.integers(CERTIFIED_LINES, size=len(STATES))]

    def at(place: int) -> float:
        shares, size = STATES[place]
        laws = laws_within(ops.box, shares, 0.04)
        reduced = combined_state(basis.xi, basis.zeta, laws, ops.offset_range, size)
        there = full.moved_by(reduced.offset_x, reduced.offset_y) if ops.offset_range else full
        exact = combined_state(*there.sampling, laws, ops.offset_range, size)
        return state_error(full, ops, reduced, exact, drawn[place], footprints)

    return max(map(at, range(len(STATES))))  # one after the other: factors of both would be the peak of memory


def sheet_error(
    full: FullPlate, ops: EffectOperators, near: Sheet | None, footprints: Sequence[Footprint] = ()
) -> float:
    """Largest error of an orthotropic sheet with other moduli than declared, see `measured_error`.

    Parameters
    ----------
    near : (4,) tuple of float or None
        Moduli about which they were made, see `simulation.reduction.effect_reduction`.
    footprints : sequence of Footprint
        The first of `EffectOperators.forces`.
    """
    away = CERTIFIED
    if near is not None:
        ratio, shear, xz, yz = (float(one) for one in np.add(near, CERTIFIED_NEAR))
        away = (ratio, shear, xz, yz)
    basis, sheet = field_basis(BENDING_DEGREE), full.shell.sheet
    laws = laws_within(ops.box, STATES[0][0], 0.04)
    reduced, exact = (
        departed_sheet(combined_state(*places, laws, 0.0, 0.0), sheet, away)
        for places in ((basis.xi, basis.zeta), full.sampling)
    )
    return state_error(full, ops, reduced, exact, CERTIFIED_LINES // 3, footprints)


def state_error(
    full: FullPlate,
    ops: EffectOperators,
    reduced: PlateState,
    exact: PlateState,
    drawn: int,
    footprints: Sequence[Footprint] = (),
) -> float:
    """Error in one state, over the peak of each transfer along the band.

    Parameters
    ----------
    reduced : PlateState
        With its fields at the points of `field_basis`.
    exact : PlateState
        The same state with its fields at the points of the full plate; with an offset of the sensor, at those of
        the moved mesh, because fields do not move with it.
    drawn : int
        Index among `CERTIFIED_LINES` lines of the band, used in addition to the line at which the reduced
        transfers are largest.
    footprints : sequence of Footprint
        The first of `EffectOperators.forces`.
    """
    lines = np.linspace(*ops.band, CERTIFIED_LINES)
    over_band = solved(ops, reduced, lines, len(footprints)).compliance()
    peak = np.abs(over_band).max(axis=-1)
    strongest = int((np.abs(over_band) / peak[..., None]).sum(axis=(0, 1)).argmax())
    matrices = full.matrices(exact, footprints=footprints)
    stiffness = matrices.plate + 1j * matrices.plate_loss + matrices.patches
    worst = 0.0
    for index in (strongest, drawn):
        omega = 2 * np.pi * lines[index]
        z = stiffness - omega**2 * matrices.mass + 1j * omega * full.damping
        answer = matrices.coupling.T @ factorize(z).solve(matrices.coupling.astype(complex))
        worst = max(worst, float((np.abs(answer - over_band[..., index]) / peak).max()))
    return worst


def solved(ops: EffectOperators, state: PlateState, frequency: Real, count: int) -> LocalSolution:
    """Solve a state, with spectra constant over frequency.

    Parameters
    ----------
    frequency : (F,) ndarray, Hz
    count : int
        The first `count` forces of `ops` are further ports.
    """
    ones, zeros = np.ones(frequency.size), np.zeros(frequency.size)
    state = state.with_(storage=ones, loss=ones, area_mass=zeros, area_resistance=zeros)
    whole = composed(ops, Coefficients.of(state, ops))
    if count:
        whole = replace(whole, coupling=np.hstack([whole.coupling, ops.forces[:, :count]]))
    return LocalSolution.of(ops, whole, state, frequency)


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
        Logarithms, see `simulation.state.plate_state`.
    """
    ratio, shear, *across = away
    factors = departed_moduli(sheet, ratio, shear)
    factors |= {name: factors[name] * one for name, one in departed_transverse(*across).items()}
    return state.with_(departures=Departures(**factors))
