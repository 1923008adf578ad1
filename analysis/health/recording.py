"""One recording of a panel, also of sound that it played: its temperature, and what it says about candidates.

The residual r, data less expected response in units of noise, is r = N a + J c + noise: a are the nuisances
(temperature, gains, material, a gradient), Gaussian with known standard deviations, c the amplitudes of the
candidates. With a eliminated, J'J and J'r are all that a date tells about c, and dates add up.

Where the drives are independent of each other, H1 of several drives gives the response to each. A panel whose
filters play one piece of sound has drives that are filtered from one signal: then the responses r_k to the drive
of input q, at which the others are u_i = G_iq / G_qq, are compared with sum_i u_i H_ik.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from analysis.arrays import Complex, Mask, Real
from analysis.checked_fields import check_finite, check_shapes
from analysis.estimation.estimators import FrfEstimate, estimate
from analysis.estimation.spectra import SampledSignals, Spectra, welch
from analysis.gap.data.compression import CompressedSweep, Nodes, compress
from analysis.gap.data.groups import TemperatureGroups
from analysis.recordings.frf import Frf

LINES_IN_HALF_WIDTH = 20.0
"""Lines of a segment in half the width of the sharpest resonance: a Hann window then lowers its peak by
1 / (3 20²), less than a part in a thousand."""
FEWEST_AVERAGES = 16.0
"""Independent segments: with fewer the variance that the coherence gives is itself uncertain by a quarter."""
INDEPENDENT = 0.03
"""Smallest over largest eigenvalue of the drives' coherence from which they are separated: the noise of the
responses is then magnified by six at most."""
ONE_SIGNAL = 0.999
"""Share of the drives' power in one signal, from which they are taken for filtered from it."""
TEMPERATURE_FOUND = 0.05
"""Step, K, below which the temperature is found: what is left is a column of the equations, to first order, and
its second order is 1e-5 of the response of a plate whose resonances move by 0.3 % per kelvin."""
MOST_STEPS = 8
"""Of the search for the temperature; from the nearest temperature of the baseline two or three are usual."""
LARGEST_STEP = 8.0
"""K: beyond, responses are not linear in the temperature (a resonance moves by its own width)."""


@dataclass(frozen=True)
class DatedRecording:
    """Responses to each input, recorded at one temperature on one date.

    Attributes
    ----------
    date : str
        Name of the date, for people.
    label : float or None
        Temperature as recorded, degrees Celsius; None where no thermometer was.
    sweeps : (S,) tuple of CompressedSweep
        Of each of the I inputs, or of `mix`, all with the same nodes.
    mix : (S, I, n) complex ndarray or None
        How much of each input a sweep has, at the nodes; None where each is of one input, in their order.
    """

    date: str
    label: float | None
    sweeps: tuple[CompressedSweep, ...] = field(repr=False)
    mix: Complex | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        if self.label is not None:
            check_finite(self, "label")
        if not self.sweeps:
            raise ValueError(f"DatedRecording {self.date!r}: no sweeps; at least one input wanted")
        if self.mix is not None:
            check_shapes(self, sweeps="S", mix="S I n")
            check_finite(self, "mix")

    @property
    def nodes(self) -> Nodes:
        """Of all sweeps."""
        return self.sweeps[0].nodes

    def white(self, values: Complex) -> Real:
        """Whiten values (..., I, K, n) at the nodes: real numbers (..., 2 S K n) of unit variance each."""
        return self.whitened(self.nodes.coefficients(self.mixed(values)))

    def mixed(self, values: Complex) -> Complex:
        """Values (..., S, K, n) of the sweeps for values (..., I, K, n) of the inputs."""
        return values if self.mix is None else np.einsum("sin,...ikn->...skn", self.mix, values)

    def whitened(self, coefficients: Complex) -> Real:
        """Do the same to spline coefficients (..., S, K, n)."""
        parts = [one.whitened(coefficients[..., index, :, :]) for index, one in enumerate(self.sweeps)]
        flat = np.stack(parts, axis=-3).reshape(*coefficients.shape[:-3], -1)
        return np.concatenate([flat.real, flat.imag], axis=-1)

    @property
    def data(self) -> Real:
        """The recording, whitened, (2 S K n,)."""
        return self.whitened(np.stack([one.coefficients for one in self.sweeps]))


class WhiteRecording(Protocol):
    """Responses in units of their errors."""

    @property
    def data(self) -> Real:
        """As recorded, (m,)."""
        ...

    def white(self, values: Complex) -> Real:
        """Do the same to values (..., I, K, n) at the nodes: (..., m)."""
        ...


@dataclass(frozen=True)
class DateEquations:
    """What one recording tells about the candidates, nuisances eliminated.

    Attributes
    ----------
    matrix : (C, C) ndarray
        J'J.
    gradient : (C,) ndarray
        J'r.
    chi2 : float
        Of the residual, with the nuisances at their best.
    dof : int
        Degrees of freedom.
    temperature, sigma : float
        As found, and its standard deviation by noise and by the other nuisances, degrees Celsius and K.
    by_change : (C,) ndarray
        How the temperature found moves with the amplitude of each candidate, K per unit.
    """

    matrix: Real = field(repr=False)
    gradient: Real = field(repr=False)
    chi2: float
    dof: int
    temperature: float
    sigma: float
    by_change: Real = field(repr=False)

    def __post_init__(self) -> None:
        check_shapes(self, matrix="C C", gradient="C", by_change="C")
        check_finite(self, "matrix", "gradient", "chi2", "temperature")


def recordings_of(frf: Frf, nodes: Nodes, excluded: Mask, date: str, inputs: int) -> list[DatedRecording]:
    """Compress the sweeps of a date, a recording for each temperature at which all inputs drove.

    Parameters
    ----------
    frf : Frf
        With the lines of the baseline.
    nodes : Nodes
        Of the baseline.
    excluded : (F,) bool ndarray
        Lines that the baseline leaves out.
    date : str
    inputs : int
        How many there are.

    Returns
    -------
    list of DatedRecording
        Repeated sweeps at one temperature averaged; empty where no temperature has all inputs.
    """
    groups, used, found = TemperatureGroups.of(frf.temperature), ~excluded, []
    for group, label in enumerate(groups.reference):
        mine = [np.flatnonzero((groups.of_sweep == group) & (frf.driven_by == source)) for source in range(inputs)]
        if any(one.size == 0 for one in mine):
            continue
        sweeps = tuple(
            compress(frf.h[one][..., used].mean(0), frf.variance[one][..., used].sum(0) / one.size**2, nodes)
            for one in mine
        )
        found.append(DatedRecording(date, float(label), sweeps))
    return found


@dataclass(frozen=True)
class ExpectedResponse:
    """Responses of a panel to each of I inputs at K outputs, at n nodes of frequency, with derivatives.

    Attributes
    ----------
    temperature : float
        Degrees Celsius.
    response : (I, K, n) complex ndarray
        In the units of the recordings.
    nuisances : (N, I, K, n) complex ndarray
        By what may differ from date to date without anything being wrong; the first is the temperature, per K.
    nuisance_sigma : (N,) ndarray
        Their standard deviations.
    changes : (C, I, K, n) complex ndarray
        By the amplitude of every candidate; C may be 0.
    """

    temperature: float
    response: Complex
    nuisances: Complex
    nuisance_sigma: Real
    changes: Complex

    def __post_init__(self) -> None:
        check_shapes(self, response="I K n", nuisances="N I K n", nuisance_sigma="N", changes="C I K n")
        check_finite(self, "temperature", "response")


class ExpectsResponses(Protocol):
    """A panel whose healthy responses are known at any temperature of a range."""

    @property
    def temperature_range(self) -> tuple[float, float]:
        """Lowest and highest temperature at which it is known, degrees Celsius."""
        ...

    def at(self, temperature: float, *, changes: bool = True) -> ExpectedResponse:
        """Return responses at a temperature [degrees Celsius]; without columns of candidates if not `changes`."""
        ...


def date_equations(recording: WhiteRecording, expected: ExpectedResponse, noise: float = 1.0) -> DateEquations:
    """Eliminate the nuisances of one recording.

    Parameters
    ----------
    recording : WhiteRecording
    expected : ExpectedResponse
    noise : float
        Chi2 per degree of freedom that is to be expected: where a model is far from the data, nuisances that are
        free but for the noise would run away to explain it.
    """
    count = len(expected.nuisances)
    columns = np.concatenate([expected.nuisances, expected.changes])
    rows = recording.white(columns)
    residual = recording.data - recording.white(expected.response)
    gram, pull = rows @ rows.T, rows @ residual
    prior = noise * np.diag(expected.nuisance_sigma**-2.0)
    solved = np.linalg.solve(gram[:count, :count] + prior, np.column_stack([gram[:count, count:], pull[:count]]))
    matrix = gram[count:, count:] - gram[count:, :count] @ solved[:, :-1]
    gradient = pull[count:] - gram[count:, :count] @ solved[:, -1]
    step = solved[:, -1]
    variance = np.linalg.inv(gram[:count, :count] + prior)[0, 0]
    return DateEquations(
        matrix=0.5 * (matrix + matrix.T),
        gradient=gradient,
        chi2=float(residual @ residual - 2.0 * pull[:count] @ step + step @ gram[:count, :count] @ step),
        dof=residual.size - count,
        temperature=expected.temperature + float(step[0]),
        sigma=float(np.sqrt(variance)),
        by_change=np.asarray(-solved[0, :-1], dtype=np.float64),
    )


def temperature_found(
    recording: DatedRecording, panel: ExpectsResponses, starts: Sequence[ExpectedResponse]
) -> float | None:
    """Find the temperature that explains a recording best: the panel is its own thermometer.

    Parameters
    ----------
    starts : sequence of ExpectedResponse
        From the best of these the search begins.

    Returns
    -------
    float or None
        Degrees Celsius; None where it lies outside the panel's range.
    """
    begun = min(starts, key=lambda one: _misfit(recording, one))
    low, high = panel.temperature_range
    here, expected = begun.temperature, begun
    for _ in range(MOST_STEPS):
        wanted = date_equations(recording, _of_one_material(expected)).temperature
        step = float(np.clip(wanted - here, -LARGEST_STEP, LARGEST_STEP))
        if not low - TEMPERATURE_FOUND <= here + step <= high + TEMPERATURE_FOUND:
            if here in (low, high):
                return None
            step = float(np.clip(here + step, low, high)) - here
        here += step
        if abs(step) < TEMPERATURE_FOUND:
            break
        expected = panel.at(here, changes=False)
    return float(np.clip(here, low, high))


def _of_one_material(expected: ExpectedResponse) -> ExpectedResponse:
    """Return it with temperature and gains as the only nuisances.

    Two kelvins from the right temperature the others together would explain more to first order than the
    temperature.
    """
    few = 1 + len(expected.response)
    return replace(
        expected,
        nuisances=expected.nuisances[:few],
        nuisance_sigma=expected.nuisance_sigma[:few],
        changes=expected.changes[:0],
    )


def _misfit(recording: DatedRecording, expected: ExpectedResponse) -> float:
    """Chi2 of a response with the gain of each input at its best."""
    data, rows = recording.data, recording.white(_by_input(expected.response))
    return float(((data - rows.T @ np.linalg.lstsq(rows.T, data, rcond=None)[0]) ** 2).sum())


def _by_input(response: Complex) -> Complex:
    """Return one row (I, I, K, n) for each input: its responses, the others zero."""
    return np.eye(len(response))[:, :, None, None] * response


def played_date(
    drives: Real,
    responses: Real,
    rate: float,
    lines: Real,
    excluded: Mask,
    nodes: Nodes,
    half_width: float,
    date: str,
) -> DatedRecording:
    """Estimate what a recording of sound says of a panel, at the lines of its baseline.

    Parameters
    ----------
    drives : (I, n) ndarray
        Of each input, in the units of the baseline.
    responses : (K, n) ndarray
        Of each output, in the units of the baseline.
    rate : float
        Hz.
    lines : (F,) ndarray
        Of the baseline, Hz, evenly spaced.
    excluded : (F,) bool ndarray
        Lines that the baseline leaves out.
    nodes : Nodes
        Of the baseline.
    half_width : float
        Half the width at half power of the sharpest resonance, Hz.
    date : str

    Raises
    ------
    ValueError
        For a recording that is too short, a silent drive, and drives that are neither independent nor one signal.
    """
    spacing = float(np.median(np.diff(lines)))
    times = max(1, int(np.ceil(LINES_IN_HALF_WIDTH * spacing / half_width)))
    segment = times / spacing
    if drives.shape[1] < segment * rate:
        raise ValueError(f"{drives.shape[1] / rate:.0f} s of sound; segments of {segment:.0f} s are needed")
    whole = welch(SampledSignals(rate, drives, responses), segment)
    place = np.searchsorted(whole.frequency, lines - 0.25 * spacing / times)
    if place[-1] >= len(whole.frequency) or whole.averages < FEWEST_AVERAGES:
        needed = FEWEST_AVERAGES / whole.averages * drives.shape[1] / rate
        raise ValueError(
            f"{drives.shape[1] / rate:.0f} s of sound up to {whole.frequency[-1]:.0f} Hz; needed: {needed:.0f} s "
            f"or more, and the band of the baseline, up to {lines[-1]:.0f} Hz"
        )
    at = place[~excluded]
    first, last = max(int(at[0]), 1), int(at[-1]) + 1
    spectra = Spectra(
        whole.frequency[first - 1 : last],
        whole.g_uu[first - 1 : last],
        whole.g_yu[first - 1 : last],
        whole.g_yy[first - 1 : last],
        whole.averages,
    )
    at = at - first  # an estimate has no line at the first frequency of its spectra
    _require_heard(spectra)
    smallest, largest = _eigenvalues(spectra)
    if len(drives) == 1 or float(np.quantile(smallest[at], 0.05)) > INDEPENDENT:
        found = estimate(spectra)
        sweeps = tuple(
            compress(found.h[:, n][:, at], _variance(found)[:, n][:, at], nodes) for n in range(len(drives))
        )
        return DatedRecording(date, None, sweeps)
    if float(np.quantile(largest[at], 0.05)) < ONE_SIGNAL:
        raise ValueError(
            "its drives are partly one signal; allowed: drives that are independent of each other, or all "
            "filtered from one signal, as flexura render writes them"
        )
    power = np.einsum("fii->i", spectra.g_uu[at + 1]).real
    loudest = int(power.argmax())
    found = estimate(_from_one(spectra, loudest))
    count = len(responses)
    u = np.ones((len(drives), len(at)), dtype=complex)
    others = [n for n in range(len(drives)) if n != loudest]
    u[others] = found.h[count:, 0][:, at]
    mix = nodes.at_nodes(compress(u, np.ones(u.shape), nodes).coefficients)
    sweep = compress(found.h[:count, 0][:, at], _variance(found)[:count, 0][:, at], nodes)
    return DatedRecording(date, None, (sweep,), mix[None])


def _require_heard(spectra: Spectra) -> None:
    power = np.einsum("fii->fi", spectra.g_uu).real[1:]
    silent = np.flatnonzero(~(power > 0.0).all(axis=0))
    if silent.size or not (spectra.g_yy[1:] > 0.0).all():
        raise ValueError("a drive or a response is silent in the band; every input must drive")


def _eigenvalues(spectra: Spectra) -> tuple[Real, Real]:
    """Eigenvalues of the drives' coherence: smallest over largest, and largest over the sum, (F - 1,) each."""
    g = spectra.g_uu[1:]
    scale = np.sqrt(np.einsum("fii->fi", g).real)
    values = np.linalg.eigvalsh(g / (scale[:, :, None] * scale[:, None, :]))
    return values[:, 0] / values[:, -1], values[:, -1] / values.sum(axis=1)


def _from_one(spectra: Spectra, which: int) -> Spectra:
    """Spectra of all responses, and the other drives behind them, by one drive."""
    others = [n for n in range(spectra.g_uu.shape[1]) if n != which]
    by: Complex = np.concatenate([spectra.g_yu[:, :, [which]], spectra.g_uu[:, others][:, :, [which]]], axis=1)
    own = np.einsum("fii->fi", spectra.g_uu).real[:, others]
    return Spectra(
        spectra.frequency,
        spectra.g_uu[:, [which]][:, :, [which]],
        by,
        np.concatenate([spectra.g_yy, own], axis=1),
        spectra.averages,
    )


def _variance(found: FrfEstimate) -> Real:
    """Variance (K, M, F), no smaller than rounding leaves."""
    if found.variance is None:
        raise ValueError("as many segments as drives; record longer")
    floor = 1e-12 * np.mean(np.abs(found.h) ** 2, axis=-1, keepdims=True)
    return np.asarray(np.maximum(found.variance, floor), dtype=np.float64)
