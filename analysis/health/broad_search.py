"""Where the fit of a large change begins.

A change that moves resonances by more than their widths is not linear: amplitudes and places by derivatives of the
healthy panel are then wrong. Over resonances as wide as the change moves them it is (`analysis.gap.data.widened`):
nothing is approximated but that the change is linear. Noise matters no longer beside a large change; what the twin
does not know does, a share of the response.

Places lie closer here than in the search of small changes: near a nodal line of the strongest modes a place half
the distance of two sites away looks different.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_shapes
from analysis.gap.data.widened import cauchy_kernel
from analysis.health.baseline import HealthBaseline
from analysis.health.candidates import DEPOLARIZATION, ChangeCandidate
from analysis.health.expected import ExpectedResponse
from analysis.health.recording import DatedRecording, date_equations

WIDENED = 0.1
"""Half-width d, share of the frequency. 2 g at a corner of a plate of 130 g move resonances by up to 8 %; with
0.05 to 0.2 the right place explained twice to nine times as much as any other."""
TWIN_ERROR = 0.03
"""Share of the root mean square response: a twin knows to three per cent what a change does."""


@dataclass(frozen=True)
class BroadRecording:
    """A recording whose resonances are widened.

    Attributes
    ----------
    recording : DatedRecording
    kernel : (n, n) ndarray
        S, at the nodes.
    scale : (S, K, 1) ndarray
        Standard deviation of what the twin does not know.
    """

    recording: DatedRecording
    kernel: Real = field(repr=False)
    scale: Real = field(repr=False)

    def __post_init__(self) -> None:
        check_shapes(self, kernel="n n", scale="S K 1")

    @classmethod
    def of(cls, recording: DatedRecording) -> "BroadRecording":
        """Widen the resonances of a recording."""
        frequency = recording.nodes.frequency
        kernel = cauchy_kernel(frequency, WIDENED)
        widened = _values(recording) @ kernel.T
        scale = TWIN_ERROR * np.sqrt((np.abs(widened) ** 2).mean(axis=-1, keepdims=True))
        return cls(recording, kernel, scale)

    def white(self, values: Complex) -> Real:
        """Do what `DatedRecording.white` does."""
        return self._whitened(self.recording.mixed(values))

    @property
    def data(self) -> Real:
        """The recording, whitened."""
        return self._whitened(_values(self.recording))

    def _whitened(self, values: Complex) -> Real:
        widened = (values @ self.kernel.T) / self.scale
        flat = widened.reshape(*values.shape[:-3], -1)
        return np.concatenate([flat.real, flat.imag], axis=-1)

    def misfit(self, expected: ExpectedResponse) -> float:
        """Mean square of what a response leaves, 1 at least."""
        left = self.data - self.white(expected.response)
        return max(float(left @ left) / left.size, 1.0)


@dataclass(frozen=True)
class BroadStart:
    """Where the fit of an effect begins.

    Attributes
    ----------
    candidate : ChangeCandidate
        At its place.
    amplitude : float
        SI.
    left : float
        Chi2 of the widened recordings that it leaves.
    """

    candidate: ChangeCandidate
    amplitude: float
    left: float


def broad_starts(
    baseline: HealthBaseline, recordings: Sequence[BroadRecording], temperatures: Sequence[float]
) -> dict[str, BroadStart]:
    """Return the best start of every family.

    Parameters
    ----------
    baseline : HealthBaseline
    recordings : sequence of BroadRecording
        Of one date.
    temperatures : sequence of float
        Of each, degrees Celsius.
    """
    unplaced = [one for one in baseline.candidates if not one.placed]
    lost = [one for one in unplaced if one.effect == DEPOLARIZATION]
    candidates = [*closer(baseline.candidates), *(one for one in unplaced if one not in lost), *lost]
    tangents = [one.tangent for one in candidates if one.tangent is not None]
    matrix, gradient, chi2 = np.zeros(len(candidates)), np.zeros(len(candidates)), 0.0
    for recording, temperature in zip(recordings, temperatures, strict=True):
        twin = baseline.linearised(temperature, tangents=tangents)
        columns = np.concatenate([twin.by_change, baseline.lost(twin.transfer)])
        expected = baseline.completed(replace(twin, by_change=columns))
        said = date_equations(recording, expected, recording.misfit(expected))
        matrix += np.diag(said.matrix)
        gradient += said.gradient
        chi2 += said.chi2
    safe = np.maximum(matrix, 1e-300)
    amplitude = gradient / safe
    either = np.array([one.two_sided for one in candidates])
    amplitude = np.where(either, amplitude, np.maximum(amplitude, 0.0))
    drop = amplitude**2 * matrix
    found: dict[str, BroadStart] = {}
    for index in np.argsort(-drop, kind="stable"):
        one = candidates[index]
        found.setdefault(one.family, BroadStart(one, float(amplitude[index]), float(chi2 - drop[index])))
    return found


def closer(candidates: Sequence[ChangeCandidate]) -> list[ChangeCandidate]:
    """Return candidates that have places, each effect at the closer places of its card."""
    found: list[ChangeCandidate] = []
    seen: set[tuple[str, str]] = set()
    for one in candidates:
        if not one.placed or one.card is None or (one.effect, one.parameter.name) in seen:
            continue
        seen.add((one.effect, one.parameter.name))
        found += [replace(one, shapes={**one.shapes, **site}) for site in one.card.closer_sites or one.card.sites]
    return found


def _values(recording: DatedRecording) -> Complex:
    """Return recorded responses at the nodes, (S, K, n)."""
    return np.array([recording.nodes.at_nodes(one.coefficients) for one in recording.sweeps])
