"""What the cursors of the FRFs stand on, in words."""

from collections.abc import Sequence

import numpy as np

from analysis.frf import Frf
from app.view.parts import decibels


def readout(frf: Frf, row: int, channel: int, line: int, more: Sequence[tuple[str, str]] = ()) -> str:
    """Return one measured value with its uncertainty as a table in HTML.

    Parameters
    ----------
    frf : Frf
    row, channel, line : int
        Sweep, output and frequency line.
    more : sequence of (str, str)
        Further rows, below.

    Returns
    -------
    str
    """
    value = frf.h[row, channel, line]
    values = [
        ("frequency", f"{frf.frequency[line]:.2f} Hz"),
        ("temperature", f"{frf.temperature[row]:.3f} °C"),
        ("|H1|", f"{abs(value):.4g} {frf.unit(channel, row)} = {decibels(value):.2f} dB"),
        ("phase", f"{np.degrees(np.angle(value)):.1f}°"),
        ("σ of H1", f"{np.sqrt(frf.variance[row, channel, line]):.2g} {frf.unit(channel, row)}"),
        ("coherence", f"{frf.coherence[row, channel, line]:.6f}"),
    ]
    if frf.excluded[line]:
        values.append(("mains line", "never fitted"))
    rows = "".join(
        f"<tr><td style='padding-right:12px'>{what}</td><td>{seen}</td></tr>" for what, seen in (*values, *more)
    )
    return f"<table>{rows}</table>"
