"""Modes of a test as JSON for machines and as tables for people."""

from typing import Any

import numpy as np

from analysis.identification.modes import Modes
from analysis.shapes.assurance import mac, mpc
from analysis.shapes.participation import ModeShapes
from app.modal_test.modes_of_test import TestModes
from app.summaries.modes import modes_record, reading_cells
from app.summaries.table import Table

MODE_HEADINGS = ("f [Hz]", "σ [Hz]", "ζ [%]", "σ [%]", "MPC", "status", "why")
AXIS = "mode: f [Hz]"
"""Label of an axis of `mode_names`."""


def mode_rows(modes: Modes, shapes: ModeShapes) -> list[tuple[str, ...]]:
    """Words under `MODE_HEADINGS` for every shape; no MPC where there is one place only, whose MPC is always 1."""
    reading, reasons, collinear = modes.reading(), modes.explanation(), mpc(shapes.shape)
    return [
        (
            *reading_cells(reading, j),
            f"{collinear[n]:.3f}" if len(shapes.places) > 1 else "–",
            modes.standing(j),
            reasons[j],
        )
        for n, j in enumerate(shapes.pole.tolist())
    ]


def mode_names(modes: Modes, shapes: ModeShapes) -> list[str]:
    """Return number and frequency of every shape, as at the axes of the AutoMAC: ``2: 262``."""
    return [f"{n}: {f:.0f}" for n, f in enumerate(modes.reading().frequency_hz[shapes.pole], start=1)]


def record_of(found: TestModes, seconds: float) -> dict[str, Any]:
    """Return what ``--json`` prints of a test that took so many seconds."""
    shapes = found.shapes
    frequency = found.modes.reading().frequency_hz
    collinear = mpc(shapes.shape)
    return {
        "title": found.frfs.title,
        "frfs": [
            {"name": t.name, "response": t.response, "reference": t.reference, "quantity": t.quantity}
            for t in found.frfs.transfers
        ],
        **modes_record(found.modes),
        "places": list(shapes.places),
        "references": list(shapes.references),
        "shapes": [
            {
                "frequency_hz": float(frequency[pole]),
                "shape": [None if np.isnan(c) else [float(c.real), float(c.imag)] for c in shape],
                "participation": [[float(c.real), float(c.imag)] for c in partner],
                "mpc": float(phase),
                "rank_one": float(share),
            }
            for pole, shape, partner, phase, share in zip(
                shapes.pole, shapes.shape, shapes.participation, collinear, shapes.rank_one, strict=True
            )
        ],
        "auto_mac": mac(shapes.shape, shapes.shape).tolist(),
        "notes": list(found.frfs.notes),
        "seconds": seconds,
    }


def shape_tables(found: TestModes) -> list[Table]:
    """Return a table of how the shapes are judged, where there is more than one place."""
    if len(found.shapes.places) < 2:
        return []
    alike = mac(found.shapes.shape, found.shapes.shape)
    np.fill_diagonal(alike, 0.0)
    frequency = found.modes.reading().frequency_hz[found.shapes.pole]
    collinear = mpc(found.shapes.shape)
    rows = []
    for n, f in enumerate(frequency):
        other = int(alike[n].argmax())
        near = f"{frequency[other]:.1f} Hz: {alike[n, other]:.2f}" if len(frequency) > 1 else ""
        rows.append((f"{f:.3f}", f"{collinear[n]:.3f}", f"{100 * found.shapes.rank_one[n]:.1f}", near))
    title = f"shapes at {len(found.shapes.places)} places"
    return [Table(title, ("f [Hz]", "MPC", "rank one [%]", "most alike: MAC"), tuple(rows))]
