"""Modes of a twin as an FRF shows them: poles with the patches connected, residues with the gain."""

from itertools import pairwise
from typing import Any

import numpy as np

from analysis.arrays import Complex, Real
from analysis.identification.lines import Lines
from analysis.identification.pole_residue import ResidualTerms
from analysis.identification.pole_search import fit, project
from analysis.material import LocalLaws
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import NO_EFFECTS, Effects
from simulation.twin.instrumented_plate import InstrumentedPlate
from simulation.twin.loaded_modes import LoadedModes, attached_poles

PARTS_OF_BAND = 6
"""Parts of the band, at the middle of each of which modes are computed where the stiffness changes along it."""
MOST_READ = 20
"""Projections of a fit that begins at a twin's own poles: where these stand alone, it needs two."""
CLOSE = 1.01
"""Ratio of neighbouring lines between which what is attached changes evenly: half the width of the resonance of a
resonator with a loss factor of 0.02."""
BAND_MARGIN = 0.3
"""Share of the band's edges up to which modes outside it have residues of their own."""


def computed_poles(
    twin: InstrumentedPlate[Any], laws: LocalLaws, effects: Effects = NO_EFFECTS, point: SweepPoint | None = None
) -> Complex | None:
    """Poles of a plate with its patches connected.

    Parameters
    ----------
    effects : mapping
        Values of those that are on.
    point : SweepPoint, optional
        Circumstances of the sweep.

    Returns
    -------
    (J,) complex ndarray or None
        rad/s, upper half plane, by ascending magnitude, up to some way beyond the band; None for a plate whose
        modes are not known: with dashpots and connected patches, or with a mass that changes along the band.
    """
    low, high = twin.band
    edges = (1.0 - BAND_MARGIN) * low, (1.0 + BAND_MARGIN) * high
    lines = np.array(twin.band)
    if any(one.acts for one in twin.state(laws, lines, effects, point).attached):
        lines = np.geomspace(edges[0], edges[1], 2 + int(np.log(edges[1] / edges[0]) / np.log(CLOSE)))
    whole = _poles(twin, laws, lines, effects, point)
    if whole is not None:
        return _within(whole, *edges)
    bounds = np.geomspace(low, high, PARTS_OF_BAND + 1)
    bounds[0], bounds[-1] = edges
    found = []
    for first, last in pairwise(bounds.tolist()):
        middle = np.clip(np.sqrt(first * last), low, high)
        here = _poles(twin, laws, np.array([middle]), effects, point)
        if here is None:
            return None
        found.append(_within(here, first, last))
    return np.concatenate(found)


def _poles(
    twin: InstrumentedPlate[Any], laws: LocalLaws, lines: Real, effects: Effects, point: SweepPoint | None
) -> Complex | None:
    solved = twin.solved(twin.state(laws, lines, effects, point), lines)
    if solved.modal is None:
        return None
    instruments = twin.instruments if point is None else twin.driven_at(point)
    if solved.modal.attached is not None:
        return attached_poles(solved, solved.modal, instruments, twin.plate.capacitance)
    if not solved.modal.count:
        return LoadedModes.of(solved, solved.modal, instruments, twin.plate.capacitance).poles
    if instruments.connected:
        return None
    roots = 1j * np.sqrt(solved.modal.damped_poles())
    return np.asarray(-np.abs(roots.real) + 1j * np.abs(roots.imag))


def _within(poles: Complex, low: float, high: float) -> Complex:
    f = np.abs(poles) / (2.0 * np.pi)
    return poles[(f >= low) & (f < high) & (poles.real < 0.0)]


def residues_at(poles: Complex, of_twin: Lines, terms: ResidualTerms) -> Complex:
    """Residues of a twin's FRFs at its poles, as an identification of these FRFs has them.

    Parameters
    ----------
    poles : (J,) complex ndarray
        rad/s.
    of_twin : Lines
        Its FRFs, with the weights of the measured ones.
    terms : ResidualTerms
        For the modes outside the band.

    Returns
    -------
    (K, J) complex ndarray
    """
    return project(of_twin, poles, terms, derivatives=False).residues


def poles_as_read(poles: Complex, of_twin: Lines, terms: ResidualTerms) -> Complex:
    """Poles that a fit makes of a twin's FRFs, begun at some poles.

    Parameters
    ----------
    poles : (J,) complex ndarray
        rad/s, upper half plane, as measured.
    of_twin, terms
        As of `residues_at`.

    Returns
    -------
    (J,) complex ndarray
        In the order of `poles`.
    """
    return fit(of_twin, poles, terms, tolerance=1e-4, max_iterations=MOST_READ).poles
