"""Mode shapes in universal files: geometry, and shapes at its nodes (data set 55), for other programs."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pyuff
from pyuff.datasets.dataset_55 import prepare_55

from analysis.identification.modes import Modes
from analysis.shapes.participation import ModeShapes
from app.files.atomic import atomic_path
from app.files.uff_geometry import geometry_text

STRUCTURAL, COMPLEX_MODES, THREE_TRANSLATIONS, DISPLACEMENT = 1, 3, 2, 8


def write_modes(
    target: Path, modes: Modes, shapes: ModeShapes, points: Mapping[int, tuple[float, float, float]]
) -> None:
    """Write shapes as complex modes, whole or not at all.

    Parameters
    ----------
    shapes : ModeShapes
        Directions -1 to -3 turn the sign; a place without a direction counts as along z.
    points : mapping of int to (float, float, float)
        m; nodes of which none is known are left out of the geometry.
    """
    nodes = sorted({int(place.partition(":")[0]) for place in shapes.places})
    with atomic_path(target) as partial:
        known = {node: points[node] for node in nodes if node in points}
        partial.write_text(geometry_text(target.stem, known), encoding="ascii")
        file = pyuff.UFF(str(partial))
        frequency = modes.reading().frequency_hz
        for number, (pole, shape) in enumerate(zip(shapes.pole, shapes.shape, strict=True), start=1):
            motion = np.zeros((3, len(nodes)), dtype=complex)
            for place, component in zip(shapes.places, shape, strict=True):
                node, _, direction = place.partition(":")
                along = int(direction) or 3
                if np.isfinite(component) and abs(along) <= 3:
                    motion[abs(along) - 1, nodes.index(int(node))] = np.sign(along) * component
            eigenvalue = complex(modes.poles[pole])
            file.write_sets(
                prepare_55(
                    id1=f"mode {number}: {frequency[pole]:.4f} Hz",
                    model_type=STRUCTURAL,
                    analysis_type=COMPLEX_MODES,
                    data_ch=THREE_TRANSLATIONS,
                    spec_data_type=DISPLACEMENT,
                    load_case=1,
                    mode_n=number,
                    eig=eigenvalue,
                    modal_a=0j,
                    modal_b=0j,
                    node_nums=nodes,
                    r1=motion[0],
                    r2=motion[1],
                    r3=motion[2],
                ),
                "add",
            )
