"""Electromechanical coupling of a plate's patches: the force of one volt."""

import numpy as np

from analysis.arrays import Real
from simulation.shell.rigidity import THX, THY, U, V
from simulation.shell.shell_plate import ShellPlate


def couplings(shell: ShellPlate, thickness: Real, bond: float = 1.0) -> list[dict[int, Real]]:
    """Force of one volt on every patch.

    Parameters
    ----------
    thickness : (cells,) or (Q,) ndarray
        Of the plate, for every cell or every point of quadrature, m.
    bond : float
        Share of the force transmitted by the bond.

    Returns
    -------
    list of dict of int to (N,) ndarray
        Of each patch, by field, values over the functions, N/V.
    """
    found = []
    for k, patch in enumerate(shell.patches):
        h = thickness if len(thickness) == len(shell.space.dx) else shell.space.spread(thickness)
        sign = 1.0 if patch.side == "top" else -1.0
        height = 0.5 * sign * (h + patch.thickness)
        factor = bond * shell.materials[patch.material].e31
        found.append(_dilatation(shell, k, factor * np.ones_like(h), factor * height))
    return found


def _dilatation(shell: ShellPlate, patch: int, flat: Real, height: Real) -> dict[int, Real]:
    """Integral under a patch of flat (u,x + v,y) + height (thx,x + thy,y), (Q,) each, by field (N,)."""
    cells = shell.under[patch]
    moments = shell.space.moments
    if shell.surface is None:
        return {
            U: moments("x", flat, cells),
            V: moments("y", flat, cells),
            THX: moments("x", height, cells),
            THY: moments("y", height, cells),
        }
    found: dict[int, Real] = {}
    for weight, strains in ((flat, (0, 1)), (height, (3, 4))):
        for strain in strains:
            for (field, letter), factor in shell.surface.strains[strain].items():
                part = moments(letter, shell.surface.area * weight * factor, cells)
                found[field] = found.get(field, 0.0) + part
    return found
