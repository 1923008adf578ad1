"""One FRF between two places of a structure, whatever measured it.

It follows exp(+jωt), in which the phase falls through a resonance; whether FRFs do so, or their conjugates, can be
seen in them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_ascending, check_finite, check_range, check_shapes

INTEGRATED = {"displacement": 0, "velocity": 1, "acceleration": 2}
"""How many times each quantity of a motion is to be integrated to a displacement."""


def direction_sign(end: str) -> float:
    """Return -1 for an end of an FRF that points along a negative axis, ``5:-3``, else 1."""
    return -1.0 if ":-" in end else 1.0


def along_axis(end: str) -> str:
    """Return an end of an FRF as if it pointed along the positive axis: ``5:+3`` of ``5:-3``."""
    return end.replace(":-", ":+")


@dataclass(frozen=True)
class MeasuredTransfer:
    """An FRF with its two ends.

    Attributes
    ----------
    name : str
        For people.
    response, reference : str
        Node and direction, as ``5:+3``: 1, 2, 3 along x, y, z, 0 where there is none.
    quantity : str
        What was measured, a quantity of ``analysis.channel`` or ``unknown``.
    frequency : (F,) ndarray
        Hz, above zero, ascending.
    h : (F,) complex ndarray
        In `units`.
    reference_quantity : str
        What drove, in the same words.
    units : (str, str)
        Of the response and of the reference, if the file gives them.
    variance : (F,) ndarray, optional
        E|h - H|^2, where it is known.
    coherence : (F,) ndarray, optional
        0 to 1, where the file holds it or it was estimated.
    """

    name: str
    response: str
    reference: str
    quantity: str
    frequency: NDArray[np.float64]
    h: NDArray[np.complex128]
    reference_quantity: str = "force"
    units: tuple[str, str] = ("", "")
    variance: NDArray[np.float64] | None = None
    coherence: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        check_shapes(self, frequency="F", h="F", variance="F", coherence="F")
        check_finite(self, "h")
        check_ascending(self, "frequency")
        check_range(self, 0.0, np.inf, "frequency", unit="Hz", above=True)


CERTAIN_RISE_SIGMA = 3.0
"""Standard deviations from which the phase is known to rise."""

LEAST_PHASE_TURN = 1.0
"""Radians by which the phase turns at least where an FRF is large: a third of what it does over a resonance."""


def turns_backward(h: NDArray[np.complex128]) -> bool:
    """Whether the phase of FRFs rises where they are large, as it does with exp(-jwt).

    The phase of a causal system falls by pi over each resonance. It rises over antiresonances, but the turns from
    line to line are weighted with the magnitude.

    Parameters
    ----------
    h : (L, F) complex ndarray

    Returns
    -------
    bool
        False where it is not certain.
    """
    size = np.abs(h) / np.maximum(np.abs(h).max(axis=1, keepdims=True), np.finfo(float).tiny)
    unit = h / np.maximum(np.abs(h), np.finfo(float).tiny)
    turns = np.sqrt(size[:, :-1] * size[:, 1:]) * (unit[:, :-1].conj() * unit[:, 1:]).imag
    return bool(turns.sum() > max(CERTAIN_RISE_SIGMA * np.sqrt((turns**2).sum()), LEAST_PHASE_TURN * len(h)))
