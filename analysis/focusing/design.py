"""Design of FIR taps from complex filters, by the method that the panel declares.

The modelling delay of a method's taps is chosen here, too.

FIR filters by least squares of the error of the field, not of the filters.

Taps are looked for among sequences that have their energy in the band: discrete prolate spheroidal sequences
(Slepian 1978).
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from analysis.arrays import Complex, Real
from analysis.focusing.energy import EnergyForms
from analysis.focusing.fir import FirBank, inverse_fft, suited_delay, taper
from analysis.focusing.methods import Method, designer
from analysis.focusing.panel import Filters, Panel
from analysis.focusing.panel_model import PanelModel, constants_at, reference_temperature
from analysis.material import MaterialLaws

OUT_OF_BAND_WEIGHT = 3e-4
"""Weight of a filter's response outside the band, relative to the median largest field energy in the band."""


NEGLIGIBLE_ENERGY = 1e-14
"""Sequences with a smaller share of energy in the band are left out: the penalty outside makes them zero."""


@dataclass(frozen=True)
class ProlateTaps:
    """A basis of M taps for filters with gain below `edges[1]`, and its spectra at the lines of the settings.

    Taps are h = Σ c_k s_k. About the middle of the taps even sequences have real and odd ones imaginary
    spectra, so that every product of two is real: e_k(f) = r_k(f) for the first `even` and -j r_k(f) for the rest.

    Attributes
    ----------
    sequences : (k, M) ndarray
        Orthonormal, even ones first.
    even : int
    spectrum : (F, k) ndarray
        r_k at the lines.
    outside : (k, k) ndarray
        ∫ e_iᴴ e_j over the frequencies beyond the edges up to half the sample rate, in lines.
    """

    sequences: Real
    even: int
    spectrum: Real
    outside: Real

    @classmethod
    def of(cls, settings: Filters) -> Self:
        """Basis for the taps, rate and edges of `settings`."""
        count, rate, head = settings.taps, settings.sample_rate, settings.edges[1]
        lines = settings.frequency
        half_bandwidth = count * head / rate
        # The share inside falls from 1 to 0 within about log(NW) sequences near number 2 NW.
        most = min(count, int(2.0 * half_bandwidth + 8.0 * np.log(4.0 * half_bandwidth + 8.0)) + 6)
        found, share = _slepian(count, half_bandwidth / count, most)
        used = np.flatnonzero(share > NEGLIGIBLE_ENERGY)
        order = np.concatenate([used[used % 2 == 0], used[used % 2 == 1]])
        sequences, even = found[order], int(np.count_nonzero(used % 2 == 0))
        # Enough Gauss points for the lowest frequencies, where a spectrum of M taps oscillates M foot/fs times.
        nodes, weights = np.polynomial.legendre.leggauss(24 + int(4.0 * count * settings.edges[0] / rate))
        low = 0.5 * settings.edges[0] * (nodes + 1.0)
        below = _spectrum(sequences, even, low, rate)
        spacing = lines[1] - lines[0]
        foot = below.T @ (0.5 * settings.edges[0] * weights[:, None] * below) / spacing
        foot[:even, even:] = foot[even:, :even] = 0.0
        outside = 0.5 * rate / spacing * np.diag(np.maximum(1.0 - share[order], 0.0)) + foot
        return cls(sequences, even, _spectrum(sequences, even, lines, rate), outside)

    @property
    def middle(self) -> float:
        """Sample about which the sequences are even or odd."""
        return 0.5 * float(self.sequences.shape[1] - 1)


def _slepian(count: int, bandwidth: float, most: int) -> tuple[Real, Real]:
    """Compute the `most` concentrated sequences (k, M), and the share of their energy within ± `bandwidth` (k,).

    `bandwidth` is a share of the sample rate. Eigenvectors of the tridiagonal matrix that commutes with the sinc
    kernel; scipy.signal has them too, but its import takes half a second of processor time.
    """
    from scipy.linalg import eigh_tridiagonal

    place = np.arange(count)
    diagonal = (0.5 * (count - 1) - place) ** 2 * np.cos(2.0 * np.pi * bandwidth)
    beside = 0.5 * place[1:] * (count - place[1:])
    _, found = eigh_tridiagonal(diagonal, beside, select="i", select_range=(count - most, count - 1))
    sequences = np.ascontiguousarray(found.T[::-1])
    power = np.abs(np.fft.rfft(sequences, 2 * count, axis=1)) ** 2
    products = np.fft.irfft(power, axis=1)[:, :count]
    kernel = np.append(2.0 * bandwidth, 4.0 * bandwidth * np.sinc(2.0 * bandwidth * place[1:]))
    share: Real = products @ kernel
    return np.asarray(sequences, float), share


def _spectrum(sequences: Real, even: int, frequency: Real, rate: float) -> Real:
    time = np.arange(sequences.shape[1]) - 0.5 * (sequences.shape[1] - 1)
    phase = 2.0 * np.pi * np.outer(frequency, time) / rate
    return np.concatenate([np.cos(phase) @ sequences[:even].T, np.sin(phase) @ sequences[even:].T], axis=1)


@dataclass(frozen=True)
class FieldFit:
    """Least-squares problem for one set of settings; each temperature needs one solution.

    Attributes
    ----------
    basis : ProlateTaps
    gain : (F,) ndarray
        Weight of each line: 1 in the band, falling to 0 at the edges.
    products : tuple of (F, i, j) ndarray
        Weighted products of spectra: even with even, odd with odd, even with odd.
    inside, outside : (k, k) ndarray
        Energy of a filter in the band, and outside it, in lines; between band and edges it is divided by the
        taper.
    frequency : (F,) ndarray
        Hz.
    sample_rate : float
        Hz.
    """

    basis: ProlateTaps
    gain: Real
    products: tuple[Real, Real, Real]
    inside: Real
    outside: Real
    frequency: Real
    sample_rate: float

    @classmethod
    def of(cls, settings: Filters) -> Self:
        """Prepare the part common to all temperatures."""
        basis, lines = ProlateTaps.of(settings), settings.frequency
        gain = taper(lines, settings)
        even, odd = basis.spectrum[:, : basis.even], basis.spectrum[:, basis.even :]
        weighted = gain[:, None, None]
        products = (
            weighted * even[:, :, None] * even[:, None, :],
            weighted * odd[:, :, None] * odd[:, None, :],
            weighted * even[:, :, None] * odd[:, None, :],
        )
        inside = _blocks(basis, gain)
        return cls(
            basis, gain, products, inside, basis.outside + _blocks(basis, 1.0 - gain), lines, settings.sample_rate
        )

    def problem(self, weight: Complex, largest: Real, filters: Complex, delay: int) -> "FieldProblem":
        """Set up the least squares for the taps of one temperature.

        Parameters
        ----------
        weight : (F, N, N) ndarray
            P, Hermitian: weight of the actuators' errors.
        largest : (F,) ndarray
            Largest eigenvalue of P.
        filters : (F, N) ndarray
            R, the complex filters to be approximated.
        delay : int
            Modelling delay, samples.

        Notes
        -----
        Minimised over real taps with the response e(f) is

            Σ g (e - R z)ᴴ P (e - R z) + w Σ_outside |e|²,   z = exp(-j2πf·delay/fs),

        g being the band's taper and w small. The normal matrix is block-Toeplitz in the taps; written in the
        prolate sequences with energy in the band it is exact to rounding, and of order 6 × 45 instead of 6 × 512.
        """
        count, basis = filters.shape[1], self.basis
        size, even = len(basis.sequences), basis.even
        normal = np.empty((count, size, count, size))
        real, imaginary = (part.reshape(len(weight), -1) for part in (weight.real, weight.imag))
        first, second = slice(None, even), slice(even, None)
        for product, part, rows, columns in (
            (self.products[0], real, first, first),
            (self.products[1], real, second, second),
            (self.products[2], imaginary, first, second),
        ):
            lines, i, j = product.shape
            block = (product.reshape(lines, -1).T @ part).reshape(i, j, count, count)
            normal[:, rows, :, columns] = block.transpose(2, 0, 3, 1)
        normal[:, second, :, first] = normal[:, first, :, second].transpose(2, 3, 0, 1)
        small = OUT_OF_BAND_WEIGHT * float(np.median(largest[self.gain == 1.0]))
        for actuator in range(count):
            normal[actuator, :, actuator] += small * self.outside
        right = self._right((weight @ filters[..., None])[..., 0], delay).ravel()
        return FieldProblem(basis.sequences, normal, right, self.inside)

    def alike(self, filters: Complex, delay: int) -> Real:
        """Least-squares taps (B, M) of `filters` (F, B), delayed, with equal weight on all lines."""
        solved = np.linalg.solve(self.inside + OUT_OF_BAND_WEIGHT * self.outside, self._right(filters, delay).T).T
        return np.asarray(solved @ self.basis.sequences)

    def _right(self, wanted: Complex, delay: int) -> Real:
        """Right-hand sides (B, k) for `wanted` (F, B)."""
        even = self.basis.even
        turn = self.gain * np.exp(-2j * np.pi * self.frequency * (delay - self.basis.middle) / self.sample_rate)
        turned = turn[:, None] * wanted
        even_part = turned.real.T @ self.basis.spectrum[:, :even]
        return np.concatenate([even_part, -turned.imag.T @ self.basis.spectrum[:, even:]], axis=1)


@dataclass(frozen=True)
class FieldProblem:
    """Normal equations of one temperature, to be solved with a penalty on each actuator's drive.

    Attributes
    ----------
    sequences : (k, M) ndarray
    normal : (N, k, N, k) ndarray
    right : (N k,) ndarray
    inside : (k, k) ndarray
        Energy of an actuator's filter in the band.
    """

    sequences: Real
    normal: Real
    right: Real
    inside: Real

    def solve(self, penalty: Real) -> Real:
        """Taps (N, M) with a penalty on each actuator's filter of `penalty` (N,) times its energy in the band."""
        from scipy.linalg import cho_factor, cho_solve

        count, size, *_ = self.normal.shape
        penalised = self.normal.copy()
        for actuator in np.flatnonzero(penalty):
            penalised[actuator, :, actuator] += penalty[actuator] * self.inside
        factor = cho_factor(penalised.reshape(count * size, -1), lower=True, overwrite_a=True, check_finite=False)
        solved: Real = cho_solve(factor, self.right, check_finite=False).reshape(count, size)
        return solved @ self.sequences


def _blocks(basis: ProlateTaps, weight: Real) -> Real:
    """Σ weight · Re(e_iᴴ e_j) over the lines (k, k); even and odd spectra are orthogonal."""
    found: Real = basis.spectrum.T @ (weight[:, None] * basis.spectrum)
    found[: basis.even, basis.even :] = found[basis.even :, : basis.even] = 0.0
    return found


PENALTY_STEPS = 30
"""Steps in which the penalty on drive is raised until every patch is within its rating."""


@dataclass(frozen=True)
class TapDesign:
    """Design of the taps of one panel; prepared once, used at every temperature.

    Attributes
    ----------
    panel : Panel
    delay : int
        Modelling delay, samples.
    limits : (N,) ndarray
        Largest peak drive of each actuator for audio within ±1, V.
    fit : FieldFit or None
        None for the inverse FFT.
    """

    panel: Panel
    delay: int
    limits: Real
    fit: FieldFit | None

    @classmethod
    def of(cls, panel: Panel, delay: int) -> Self:
        """Prepare the design of a panel's filters with a modelling `delay`, samples."""
        settings = panel.filters
        fit = FieldFit.of(settings) if settings.design == "field" else None
        return cls(panel, delay, panel.limits, fit)

    def taps(self, forms: EnergyForms, filters: Complex) -> Real:
        """Taps (N, M) for `filters` (F, N) of one temperature, whose energy forms are (1, F, N, N).

        Σ|taps| is the largest voltage that audio within ±1 can cause. If it exceeds an actuator's limit, the
        penalty on that actuator's drive is raised until it does not; if that is not enough, or the aim is a sound,
        all filters are scaled down, which does not change the contrast.
        """
        settings = self.panel.filters
        if self.fit is None:
            taps = inverse_fft(filters[None], np.zeros(1), settings, self.delay).taps[0]
        else:
            weighed = forms.weighted(settings.kappa)
            weight, largest = weighed.damped(settings.tolerance)[0], weighed.largest[0]
            problem = self.fit.problem(weight, (1.0 + settings.tolerance**2) * largest, filters, self.delay)
            penalty = np.zeros(len(self.limits))
            taps = problem.solve(penalty)
            seed = settings.tolerance**2 * float(np.median(largest))
            # A penalty would change the sound at the loudest lines only; all filters scaled keep its shape.
            for _ in range(PENALTY_STEPS if settings.aim == "field" else 0):
                excess = peak_drive(taps) / self.limits
                if (excess <= 1.0).all():
                    break
                raised = np.maximum(penalty, seed) * np.maximum(1.05 * excess, 1.0) ** 2
                penalty = np.where(excess > 1.0, raised, penalty)
                taps = problem.solve(penalty)
        return np.asarray(taps / max(1.0, float((peak_drive(taps) / self.limits).max())))

    def bank(self, taps: Real, temperature: Real) -> FirBank:
        """Bank of `taps` (T, N, M) with this design's rate and delay."""
        return FirBank(taps, temperature, self.panel.filters.sample_rate, self.delay)


def fitted(filters: Complex, temperature: Real, fit: FieldFit, delay: int) -> FirBank:
    """Least-squares taps for given filters, with equal weight on all lines, for use without a field.

    Parameters
    ----------
    filters : (T, F, N) ndarray
        At the lines of `fit`, V per unit of audio signal.
    temperature : (T,) ndarray, °C
    fit : FieldFit
        Prepared with the filters' settings.
    delay : int
        Modelling delay, samples.
    """
    count, lines, actuators = filters.shape
    taps = fit.alike(filters.transpose(1, 0, 2).reshape(lines, -1), delay)
    return FirBank(taps.reshape(count, actuators, -1), temperature, fit.sample_rate, delay)


def peak_drive(taps: Real) -> Real:
    """Largest drive (...,) that a signal within ±1 can cause through `taps` (..., M): Σ|taps|."""
    peak: Real = np.abs(taps).sum(axis=-1)
    return peak


def tap_design(method: Method, model: PanelModel, panel: Panel, laws: MaterialLaws) -> TapDesign:
    """Prepare the tap design of a method, with the declared delay or a suitable one.

    A suitable delay is half the taps for STIF; for the others it is the one with most energy within the taps at
    the reference temperature.

    Parameters
    ----------
    method : str
        One of `METHODS`.
    """
    settings = panel.filters
    if method == "stif" or settings.delay is not None:
        return TapDesign.of(panel, settings.middle)
    (constants,) = constants_at(laws, np.array([reference_temperature(panel, laws)]))
    amplitude = model.amplitudes(*constants, settings.frequency)
    forms = model.space.forms([amplitude], panel.target.displacement)
    wanted = designer(method, model, panel, settings.frequency)(constants, lambda: amplitude, forms)
    return TapDesign.of(panel, suited_delay(wanted[None], settings))
