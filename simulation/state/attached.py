"""Something attached to the normal motion of a plate at any place: where it acts, and how stiff it is felt.

The deflection at a place is interpolated between those of the places nearby, by moving least squares with cubic
polynomials (Lancaster and Salkauskas, Math. Comp. 37, 1981): a smooth function of the place. An attachment of
dynamic stiffness d acts through the local compliance c that the reduced plate lacks there: as d/(1 + d c), with
c in inverse proportion to the plate's complex modulus. Without it, 1 g on 3 mm of polypropylene is 0.4 to 1.4 %
too light at 450 Hz, at a corner 2 to 4 %. The area that is held decides it, and nobody knows that: c has a
tolerance.
"""

from dataclasses import dataclass
from typing import Any, Protocol, Self

import numpy as np

from analysis.arrays import Numbers, Real
from simulation.state.plate_state import Attached, PlateState

PLACES_RADIUS = 3.0
"""Radius within which places count, in spacings: some thirty in the middle of a plate."""
OFF_PLATE_DISTANCE = 0.8
"""Distance from the nearest place, in spacings, from which a point is off the plate: in it, it is below 0.75."""
FEWEST_PLACES = 14
"""Number of places wanted within it: cubic polynomials have ten terms."""


class Attachable(Protocol):
    """Places of a reduced plate at which something may be attached, see `EffectOperators`."""

    @property
    def places(self) -> Real:
        """(G, 2), m."""
        ...

    @property
    def place_deflection(self) -> Real:
        """Deflection w there, (G, r)."""
        ...

    @property
    def place_compliance(self) -> Real:
        """Compliance there that the coordinates lack, times Young's modulus, (G,), 1/m."""
        ...

    @property
    def place_spacing(self) -> float:
        """Distance between two places, m."""
        ...


@dataclass(frozen=True)
class Seat:
    """Where and how one attachment acts; complex for a state with a complex step.

    Attributes
    ----------
    row : (r,) ndarray
        Deflection there.
    stiffness, loss : (F,) ndarray
        Real and imaginary part of the dynamic stiffness, as felt through the local compliance, N/m.
    """

    row: Numbers
    stiffness: Numbers
    loss: Numbers

    @classmethod
    def of(cls, ops: Attachable, one: Attached, state: PlateState) -> Self:
        """Seat an attachment on a plate in a state.

        Parameters
        ----------
        state : PlateState
            Its material gives the local compliance.

        Returns
        -------
        Seat

        Raises
        ------
        ValueError
            Where the plate has no places at which something may be attached, or off the plate.
        """
        near, weights, smooth = _weights(ops, one.x, one.y)
        temperature = state.mean_temperature
        eta = state.laws.loss_factor(temperature)
        local = state.departures.place_compliance * (smooth @ ops.place_compliance[near])
        soft = local / state.laws.youngs_modulus(temperature) / (1.0 + eta**2)
        a, b, c, e = one.stiffness, one.loss, soft, -eta * soft
        # d/(1 + d c) in real numbers, each of which may be stepped: d = a + j b, the compliance c + j e
        size = (1.0 + a * c - b * e) ** 2 + (a * e + b * c) ** 2
        square = a * a + b * b
        return cls(
            weights @ ops.place_deflection[near], (a + square * c) / size, np.asarray((b - square * e) / size)
        )


def deflection_at(ops: Attachable, x: float, y: float) -> Real:
    """Row that gives the deflection at a place of a reduced plate.

    Parameters
    ----------
    x, y : float
        m.

    Returns
    -------
    (r,) ndarray

    Raises
    ------
    ValueError
        Off the plate.
    """
    near, weights, _ = _weights(ops, x, y)
    return np.asarray(weights @ ops.place_deflection[near])


def _weights(ops: Attachable, x: Any, y: Any) -> tuple[Any, Numbers, Numbers]:
    """Places (n,) near (x, y), their weights in a cubic interpolation, and in a linear one."""
    if not len(ops.places):
        raise ValueError("this twin has no places at which something undeclared may be attached")
    away = np.hypot(*(ops.places - np.real([x, y])).T)
    if away.min() > OFF_PLATE_DISTANCE * ops.place_spacing:
        raise ValueError(f"nothing can be attached at {np.real(x):.4g}, {np.real(y):.4g} m: it is off the plate")
    last = min(FEWEST_PLACES, away.size) - 1
    reach = max(PLACES_RADIUS * ops.place_spacing, 1.2 * float(np.partition(away, last)[last]))
    near = np.flatnonzero(away < reach)
    u, v = (ops.places[near, 0] - x) / reach, (ops.places[near, 1] - y) / reach
    weight = (1.0 - (u * u + v * v)) ** 4
    cubic = np.array([u**i * v**j for i, j in POWERS])
    found = []
    for count in (len(POWERS), 3):
        rows = cubic[:count]
        found.append(np.linalg.solve((rows * weight) @ rows.T, rows * weight)[0])
    return near, found[0], found[1]


POWERS = [(n - j, j) for n in range(4) for j in range(n + 1)]
"""Powers of both coordinates in a cubic polynomial, those of a linear one first."""
