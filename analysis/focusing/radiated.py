"""Sound that a panel radiates over temperature: with filters that follow it, and with those of one temperature."""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Complex, Mask, Real
from analysis.checked_fields import check_ascending, check_finite, check_shapes
from analysis.focusing.design import peak_drive
from analysis.focusing.energy import FieldSpace
from analysis.focusing.fir import FirBank
from analysis.focusing.measured import MeasuredPanel
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import PanelModel, responses
from analysis.focusing.performance import area_normalised
from analysis.focusing.sound_aim import RESPONSE_TOLERANCE, SoundAim
from analysis.material import MaterialLaws
from analysis.progress import Progress
from analysis.radiation.measures import (
    arc,
    directivity_index,
    driven_variance,
    group_delay,
    power_error,
    pressure_sigma,
    radiation_efficiency,
    ripple,
    sound_pressure_level,
    third_octave_levels,
    third_octaves,
)
from analysis.radiation.radiator import Radiator

DEGREES = np.arange(-90.0, 90.5, 5.0)
"""Angles from the panel's normal of the polar diagrams, in the planes of x and of y."""


@dataclass(frozen=True)
class RadiatedSound:
    """Sound of filters at T temperatures, F lines of the band and L listeners, per unit of audio signal.

    Attributes
    ----------
    pressure : (T, L, F) ndarray
        Complex, Pa, modelling delay removed.
    power : (T, F) ndarray
        W.
    target_share : (T, F) ndarray
        Share of the power that the target radiates in the sound of the whole panel: may leave 0 to 1, where target
        and rest work against each other.
    efficiency : (T, F) ndarray
        Radiation efficiency.
    directivity : (T, F) ndarray
        Directivity index, dB.
    polar : (T, 2, D, B) ndarray
        Level in third-octave bands far away at `DEGREES` in the planes of x and of y, dB of the normal's.
    contrast : (T, F) ndarray
        Paper eq. (9), literal.
    peak : (T, N) ndarray
        Largest drive that audio within ±1 can cause, V or N.
    zones : (T, F) ndarray, optional
        Acoustic contrast, dB: mean square pressure at the listeners played to over that at the others, in which
        every actuator is `RESPONSE_TOLERANCE` off; None without others.
    pressure_sigma : (T, L, F) ndarray, optional
        Standard deviation by the noise of measured transfers, Pa.
    power_sigma : (T, F) ndarray, optional
        W; the noise's mean is subtracted from `power`.
    """

    pressure: Complex
    power: Real
    target_share: Real
    efficiency: Real
    directivity: Real
    polar: Real
    contrast: Real
    peak: Real
    zones: Real | None = None
    pressure_sigma: Real | None = None
    power_sigma: Real | None = None

    def __post_init__(self) -> None:
        lines = ("power", "target_share", "efficiency", "directivity", "contrast", "zones", "power_sigma")
        check_shapes(self, pressure="T L F", pressure_sigma="T L F", peak="T N", **dict.fromkeys(lines, "T F"))
        check_finite(self, "pressure")


@dataclass(frozen=True)
class Radiation:
    """Sound of a panel over temperature.

    Attributes
    ----------
    temperature : (T,) ndarray, °C
    frequency : (F,) ndarray
        Lines of the band, Hz.
    wanted : (L, F) ndarray
        Complex pressure wanted at the listeners, Pa per unit of audio signal.
    loud : (L,) ndarray of bool
        Which of them are played to.
    names : tuple of str
        Of the listeners.
    limits : (N,) ndarray
        Rated drive of the actuators, V; infinite for forces.
    reference_temperature : float
        Of the filters that are kept, °C.
    area_share : float
        Area of the target over that of the plate.
    following, kept : RadiatedSound
        With the filters of each temperature, and with those of the reference at all of them.
    zone_bound : (T, F) ndarray, optional
        Largest acoustic contrast of any filters, with the same tolerance, dB.
    """

    temperature: Real
    frequency: Real
    wanted: Complex
    loud: Mask
    names: tuple[str, ...]
    limits: Real
    reference_temperature: float
    area_share: float
    following: RadiatedSound
    kept: RadiatedSound
    zone_bound: Real | None = None

    def __post_init__(self) -> None:
        check_shapes(self, temperature="T", frequency="F", wanted="L F", loud="L", names="L", zone_bound="T F")
        sounds = dict.fromkeys(("following.pressure", "kept.pressure"), "T L F")
        check_shapes(self, temperature="T", frequency="F", names="L", **sounds)
        check_finite(self, "temperature", "wanted")
        check_ascending(self, "frequency")

    @property
    def middles(self) -> Real:
        """Third-octave bands (B,), Hz."""
        return third_octaves(self.frequency)[0]

    @property
    def _loud(self) -> Mask:
        return np.asarray(self.loud, dtype=bool)

    def relative(self, sound: RadiatedSound) -> Complex:
        """Pressure over that wanted (T, l, F) at the l listeners that are played to."""
        return np.asarray(sound.pressure[:, self._loud] / self.wanted[self._loud])

    def levels(self, sound: RadiatedSound) -> Real:
        """Third-octave levels (T, l, B) at the listeners played to, dB of the wanted one."""
        return third_octave_levels(self.relative(sound), self.frequency)

    def ripple(self, sound: RadiatedSound) -> Real:
        """Third-octave ripple (T,), ± dB, of the listener that has most."""
        return np.asarray(ripple(self.relative(sound), self.frequency).max(axis=1))

    def line_levels(self, sound: RadiatedSound) -> Real:
        """Level (T, l, F) at every line, dB of the wanted one."""
        return np.asarray(20.0 * np.log10(np.maximum(np.abs(self.relative(sound)), 1e-10)))

    def area_contrast(self, sound: RadiatedSound) -> Real:
        """Contrast of the field, normalised by area (T, F)."""
        return area_normalised(sound.contrast, self.area_share)

    def rated_level(self, sound: RadiatedSound) -> Real:
        """Sound pressure level (T,), dB re 20 µPa, at the first listener played to, mean square of the band.

        Of a sine whose amplitude is as large as audio may be for no actuator to exceed its rating.
        """
        share = (self.limits / np.maximum(sound.peak, np.finfo(float).tiny)).min(axis=1)
        first = sound.pressure[:, int(np.argmax(self._loud))]
        level = sound_pressure_level(np.sqrt(np.mean(np.abs(first) ** 2, axis=1)) + 0j)
        return np.asarray(level + 20.0 * np.log10(share))

    def delay_spread(self, sound: RadiatedSound) -> Real:
        """Largest less smallest group delay (T,), s, at the listeners played to, the way to them taken off."""
        delay = group_delay(self.relative(sound), self.frequency)
        return np.asarray(np.ptp(delay, axis=2).max(axis=1))


def radiate(
    model: PanelModel,
    panel: Panel,
    laws: MaterialLaws,
    bank: FirBank,
    reference: float,
    report: Progress = lambda _stage, _share: None,
) -> Radiation:
    """Compute the sound of filters at their temperatures.

    Parameters
    ----------
    bank : FirBank
        At T temperatures.
    reference : float
        Temperature of the filters that are kept, °C; the nearest of the bank is taken.
    report : callable
        Called with the stage and the share done.

    Raises
    ------
    ValueError
        For a material outside the box of the model, and a grid too coarse for the wavelength.
    """
    lines = panel.filters.frequency
    lines = lines[panel.filters.in_band(lines)]
    work = _Work.of(panel, model.space, bank, reference)
    for t, (_, amplitude) in enumerate(responses(model, laws, bank.temperature, lines)):
        work.take(amplitude)
        report("Sound", (t + 1) / len(bank.temperature))
    return work.result()


def radiate_measured(
    measured: MeasuredPanel, bank: FirBank, reference: float, report: Progress = lambda _stage, _share: None
) -> Radiation:
    """Compute the sound of filters from measured transfers, with the errors that their noise makes.

    Parameters
    ----------
    bank : FirBank
        At the measured temperatures.
    reference : float
        Temperature of the filters that are kept, °C.
    report : callable
        Called with the stage and the share done.

    Raises
    ------
    ValueError
        For filters of other temperatures, and points too coarse for the wavelength.
    """
    temperature, panel = measured.transfers.temperature, measured.panel
    if bank.temperature.shape != temperature.shape or np.abs(bank.temperature - temperature).max() > 1e-6:
        raise ValueError(
            f"filters of {bank.temperature.tolist()} °C; the transfers were measured at {temperature.tolist()} "
            "°C: design them with flexura focus --transfers"
        )
    band = panel.filters.in_band(panel.filters.frequency)
    work = _Work.of(panel, measured.space, bank, reference)
    for t in range(len(temperature)):
        work.take(measured.amplitudes(t)[:, band], measured.variances(t)[:, band])
        report("Sound", (t + 1) / len(temperature))
    return work.result()


@dataclass
class _Work:
    """Fields of both sets of filters, gathered one temperature after the other."""

    panel: Panel
    space: FieldSpace
    aim: SoundAim
    bank: FirBank
    reference: int
    filters: Complex
    fields: list[tuple[Complex, Complex]]
    variances: list[tuple[Real, Real]]
    pressures: list[tuple[Complex, Complex]]
    sigmas: list[tuple[Real, Real]]
    zones: list[tuple[Real, Real, Real]]

    @classmethod
    def of(cls, panel: Panel, space: FieldSpace, bank: FirBank, reference: float) -> "_Work":
        aim = SoundAim.of(panel, space.grid, "listeners")
        nearest = int(np.argmin(np.abs(bank.temperature - reference)))
        filters = bank.response(panel.filters.frequency[aim.band])
        return cls(panel, space, aim, bank, nearest, filters, [], [], [], [], [])

    def take(self, amplitude: Complex, variance: Real | None = None) -> None:
        """Add the next temperature: `amplitude` (N, F, r), and of measured transfers the variance (N, F, K)."""
        kernel = self.aim.kernel[:, self.aim.band]
        heard = np.einsum("lfr,nfr->lfn", kernel @ self.space.deflection, amplitude)
        both = (self.filters[len(self.fields)], self.filters[self.reference])
        fields = [np.einsum("nfr,fn->fr", amplitude, one) for one in both]
        self.fields.append((fields[0], fields[1]))
        pressures = [np.einsum("lfn,fn->lf", heard, one) for one in both]
        self.pressures.append((pressures[0], pressures[1]))
        if not self.aim.loud.all():
            self.zones.append(_zones(heard, self.aim.loud, both))
        if variance is not None:
            spread = [driven_variance(variance, one) for one in both]
            self.variances.append((spread[0], spread[1]))
            sigmas = [pressure_sigma(kernel, one) for one in spread]
            self.sigmas.append((sigmas[0], sigmas[1]))

    def result(self) -> Radiation:
        aim, bank = self.aim, self.bank
        kept = np.broadcast_to(bank.taps[self.reference], bank.taps.shape)
        return Radiation(
            temperature=bank.temperature,
            frequency=self.panel.filters.frequency[aim.band],
            wanted=aim.wanted[:, aim.band],
            loud=aim.loud,
            names=tuple(one.name for one in self.panel.listeners),
            limits=self.panel.limits,
            reference_temperature=float(bank.temperature[self.reference]),
            area_share=self.space.grid.target_share,
            following=self._sound(0, peak_drive(bank.taps)),
            kept=self._sound(1, peak_drive(kept)),
            zone_bound=np.array([three[2] for three in self.zones]) if self.zones else None,
        )

    def _sound(self, which: int, peak: Real) -> RadiatedSound:
        fields = np.array([pair[which] for pair in self.fields])
        lines, grid = self.panel.filters.frequency[self.aim.band], self.space.grid
        sources, radiator = self.aim.sources, self.aim.radiator
        parts = (sources.lumped, sources.lumped * grid.target)
        whole, inside = (np.asarray(fields @ (part @ self.space.deflection).T, dtype=complex) for part in parts)
        energy, target = (
            np.sum(np.abs(fields @ root.T) ** 2, axis=2) for root in (self.space.plate, self.space.target)
        )
        power, share = self._powers(whole, inside, lines)
        bias, sigma = self._noise(which, fields, lines)
        on_axis, polar = self._far(whole, lines)
        power = power - bias
        return RadiatedSound(
            pressure=np.array([pair[which] for pair in self.pressures]),
            power=power,
            target_share=share / np.where(power > 0.0, power, np.nan),
            efficiency=np.array(
                [radiation_efficiency(radiator, *one, lines) for one in zip(power, energy, strict=True)]
            ),
            directivity=directivity_index(radiator, on_axis, np.maximum(power, 1e-30)),
            polar=polar,
            contrast=target / np.maximum(energy, np.finfo(float).tiny),
            peak=np.asarray(peak),
            zones=np.array([three[which] for three in self.zones]) if self.zones else None,
            pressure_sigma=np.array([pair[which] for pair in self.sigmas]) if self.sigmas else None,
            power_sigma=sigma,
        )

    def _powers(self, whole: Complex, inside: Complex, lines: Real) -> tuple[Real, Real]:
        """Power (T, F), and that of the target in the sound of all, from sources (T, F, m)."""
        power, target = np.empty(whole.shape[:2]), np.empty(whole.shape[:2])
        for f, line in enumerate(lines):
            pushed = whole[:, f] @ self.aim.sources.resistance(float(line))
            power[:, f] = np.sum(whole[:, f].conj() * pushed, axis=1).real
            target[:, f] = np.sum(inside[:, f].conj() * pushed, axis=1).real
        return power, target

    def _noise(self, which: int, fields: Complex, lines: Real) -> tuple[Real | float, Real | None]:
        """Bias (T, F) of the power by noise, and its standard deviation; 0 and None without variances."""
        if not self.variances:
            return 0.0, None
        pairs = [
            power_error(self.aim.sources, field @ self.space.deflection.T, spread[which], lines)
            for field, spread in zip(fields, self.variances, strict=True)
        ]
        return np.array([bias for bias, _ in pairs]), np.array([sigma for _, sigma in pairs])

    def _far(self, whole: Complex, lines: Real) -> tuple[Complex, Real]:
        """Pressure on the normal far away (T, F), times the distance, and polar levels (T, 2, D, B)."""
        nodes = self.aim.sources.nodes
        equivalent = Radiator(nodes, np.ones(len(nodes)), self.aim.radiator.air, self.aim.radiator.mounting)
        directions = np.concatenate([arc(DEGREES, azimuth) for azimuth in (0.0, 90.0)])
        far = np.empty((len(whole), len(directions), len(lines)), dtype=complex)
        for f, line in enumerate(lines):
            far[:, :, f] = whole[:, f] @ equivalent.far_field(directions, np.array([line]))[:, 0].T
        front = int(np.argmin(np.abs(DEGREES)))
        levels = third_octave_levels(far, lines)
        levels = levels - levels[:, front : front + 1]
        return far[:, front], levels.reshape(len(whole), 2, len(DEGREES), -1)


def _zones(heard: Complex, loud: Mask, filters: tuple[Complex, Complex]) -> tuple[Real, Real, Real]:
    """Acoustic contrast (F,) of both filters (F, N), and its bound, dB, from the transfers (L, F, N)."""
    forms = []
    for chosen in (loud, ~loud):
        part = heard[chosen]
        form = np.einsum("lfn,lfm->fnm", part.conj(), part) / len(part)
        spread = np.einsum("fnn->fn", form).real
        forms.append(form + RESPONSE_TOLERANCE**2 * spread[:, :, None] * np.eye(spread.shape[1]))
    played, others = forms
    ratios = [
        np.einsum("fn,fnm,fm->f", one.conj(), played, one).real
        / np.maximum(np.einsum("fn,fnm,fm->f", one.conj(), others, one).real, 1e-300)
        for one in filters
    ]
    values, vectors = np.linalg.eigh(others)
    root = vectors / np.sqrt(np.maximum(values, 1e-300))[:, None, :]
    bound = np.linalg.eigvalsh(root.conj().swapaxes(1, 2) @ played @ root)[:, -1]
    own, kept, largest = (np.asarray(10.0 * np.log10(np.maximum(one, 1e-30))) for one in (*ratios, bound))
    return own, kept, largest
