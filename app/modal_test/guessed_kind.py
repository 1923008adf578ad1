"""Kind of a test, and its segments, from the roles of its channels and the course of its drive."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.excitation import fitting_segments, is_impacts
from analysis.estimation.recording import SampledSignals
from app.files.measurements.columns import Columns
from app.files.modal_test_toml import ModalTest
from app.modal_test.guessed_channels import NewTest
from app.modal_test.sample_rates import sample_rate

SEGMENT_SECONDS = 2.0
"""Of a segment; lines lie 0.5 Hz apart."""


def guessed_kind(columns: Columns, channels: Mapping[str, Mapping[str, Any]], said: NewTest) -> str:
    """Return the kind of test.

    Parameters
    ----------
    channels : mapping
        Role of each column.

    Returns
    -------
    str
        As said; ``frf`` where there are frequencies and FRFs; else ``hammer`` where the drive acts in blows, and
        ``continuous`` where it does not.
    """
    roles = {channel["role"] for channel in channels.values()}
    frfs = "frf" in roles or {"real", "imaginary"} <= roles or {"magnitude", "phase"} <= roles
    if said.kind or ("frequency" in roles and frfs):
        return said.kind or "frf"
    drives = _signals(columns, [name for name, one in channels.items() if one["role"] == "drive"])
    return "hammer" if drives is None or all(map(is_impacts, drives)) else "continuous"


def guessed_segments(file: str, columns: Columns, test: ModalTest) -> dict[str, Any]:
    """Return the segments of a continuous test: a whole period or sweep, or else Hann's of `SEGMENT_SECONDS`.

    Parameters
    ----------
    file : str
        Its name.
    test : ModalTest
        Says what each column is.

    Returns
    -------
    dict
        ``seconds``, ``window``, ``overlap``.
    """
    seconds, window, overlap = SEGMENT_SECONDS, "hann", 0.5
    drives = _signals(columns, [name for name, one in test.channels.items() if one.role == "drive"])
    if drives is not None:
        try:
            recording = SampledSignals(sample_rate(file, columns, test)[0], drives, drives)
        except ValueError:  # said when the test is identified
            pass
        else:
            seconds, window, overlap = fitting_segments(recording, SEGMENT_SECONDS)
    return {"seconds": seconds, "window": window, "overlap": overlap}


def _signals(columns: Columns, names: Sequence[str]) -> NDArray[np.float64] | None:
    """Signals of channels, (M, N); None where they cannot be compared."""
    signals = [columns.values[name].real for name in names if name in columns.values]
    if len({len(one) for one in signals}) != 1:
        return None
    return np.array(signals) if all(np.isfinite(one).all() and np.ptp(one) > 0.0 for one in signals) else None
