"""Angles between neighbouring edges of a face."""

from dataclasses import dataclass

import numpy as np

from simulation.meshing.arrangement import Arrangement, Face, HalfEdge, direction

CONVEX, REENTRANT = np.deg2rad(140.0), np.deg2rad(220.0)
"""Angles inside a face below and above which a corner gets cells of its own."""


@dataclass(frozen=True)
class Corner:
    """The angle of a face at a node, from one half-edge to the next, rad."""

    node: int
    before: HalfEdge
    after: HalfEdge
    angle: float


def corners_of(plan: Arrangement, face: Face) -> list[list[Corner]]:
    """Angles of a face, cycle by cycle, each between a half-edge and the next."""
    found = []
    for cycle in face.cycles:
        row = []
        for before, after in zip(cycle, (*cycle[1:], cycle[0]), strict=True):
            back = direction(plan.curve(before).part(1.0, 0.0))
            ahead = direction(plan.curve(after))
            turn = np.arctan2(back[1], back[0]) - np.arctan2(ahead[1], ahead[0])
            row.append(Corner(plan.start(after), before, after, float(turn % (2 * np.pi)) or 2 * np.pi))
        found.append(row)
    return found
