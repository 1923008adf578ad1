"""Error of a reduced plate with effects, measured against the full one in states outside the training set."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from analysis.arrays import Real
from analysis.channel import Footprint
from simulation.reduction.composition import Coefficients, composed
from simulation.reduction.effect_operators import BENDING_DEGREE, EffectOperators
from simulation.shell.unknowns import factorize
from simulation.state.departures import CERTIFIED, CERTIFIED_NEAR, Sheet
from simulation.state.extreme_states import combined_state, departed_sheet, laws_within
from simulation.state.field_basis import field_basis
from simulation.state.plate_state import PlateState
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
