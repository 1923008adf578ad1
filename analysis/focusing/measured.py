"""A panel given by measured transfers from actuators to the points of a grid, with their variances.

Filters are designed from them at the measured temperatures, without laws or twin.
"""

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from analysis.arrays import Complex, Real
from analysis.focusing.design import TapDesign
from analysis.focusing.energy import EnergyForms, FieldSpace, Grid
from analysis.focusing.fir import suited_delay
from analysis.focusing.methods import Method, MethodComparison, designer
from analysis.focusing.over_temperature import Answer, Focusing, design_and_assess
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import NoModes
from analysis.focusing.performance import aim
from analysis.focusing.sound_aim import SoundAim
from analysis.progress import Progress

POINTS_ALONG_BOX = 400
"""Points along each side of the plate's box, to divide its area among the measured points."""


@dataclass(frozen=True)
class MeasuredTransfers:
    """Displacement of the plate per unit of every actuator's drive, at some temperatures.

    Attributes
    ----------
    temperature : (T,) ndarray
        Ascending, degrees Celsius.
    points : (K, 2) ndarray
        Measured points, m.
    frequency : (F,) ndarray
        Hz, ascending.
    transfer : (T, N, F, K) ndarray
        Complex, m per V or N.
    variance : (T, N, F, K) ndarray
        Of the transfers, E|error|², m2 per V2 or N2; 0 where it is not known.
    """

    temperature: Real
    points: Real
    frequency: Real
    transfer: Complex
    variance: Real

    def __post_init__(self) -> None:
        count, lines, points = self.temperature.shape, self.frequency.shape, self.points.shape
        if len(count) != 1 or len(lines) != 1 or lines[0] < 2 or points[1:] != (2,):
            raise ValueError(
                f"temperature {count}, frequency {lines} and points {points} must be (T,), (F,) with 2 lines or "
                "more, and (K, 2)"
            )
        actuators = self.transfer.shape[1:2]
        shape = (*count, *actuators, *lines, points[0])
        if self.transfer.shape != shape or self.variance.shape != shape:
            raise ValueError(
                f"transfer {self.transfer.shape} and variance {self.variance.shape} must be (T, N, F, K) with "
                f"T {count[0]}, F {lines[0]} and K {points[0]}"
            )
        if not np.isfinite(self.temperature).all():
            raise ValueError(f"temperature {self.temperature}: allowed are finite numbers of °C")
        missing = ~np.isfinite(self.transfer).all(axis=(0, 2))
        if missing.any():
            actuator, point = np.argwhere(missing)[0]
            raise ValueError(
                f"{int(missing.sum())} of {missing.size} transfers are missing or not finite, the first from "
                f"actuator {actuator + 1} to point {point + 1}; measure them, or leave the point out"
            )
        if not (np.isfinite(self.variance) & (self.variance >= 0.0)).all():
            raise ValueError("a variance is negative or not finite; allowed 0 or more")
        for name, axis in (("temperature", self.temperature), ("frequency", self.frequency)):
            if not (np.diff(axis) > 0.0).all():
                raise ValueError(f"{name} must ascend")


@dataclass(frozen=True)
class MeasuredPanel:
    """Fields and energy forms from measured transfers at the settings' lines, corrected for noise.

    Notes
    -----
    Noise of variance σ² adds a bias of Σ w σ² on the diagonal of Hᴴ W H to the energy of each actuator. It is
    subtracted to assess filters. For the design half of it is kept: with all of it filters are too quiet, and with
    none the smallest singular values are noise. At signal-to-noise ratios of 10 to 30 dB, contrast with half of it
    was within 0.005 of the best share, or the best. Energies over the target and outside it that become negative
    are set to zero: where noise exceeds the field, contrast would be a ratio of noise.
    """

    panel: Panel
    transfers: MeasuredTransfers

    @cached_property
    def grid(self) -> Grid:
        """Measured points, each with the area of the plate nearest to it and the target's share of that area."""
        from scipy.spatial import cKDTree

        panel, points = self.panel, self.transfers.points
        plate = panel.plate
        low, high = plate.bounds
        steps = (np.arange(POINTS_ALONG_BOX) + 0.5) / POINTS_ALONG_BOX
        samples = np.stack(np.meshgrid(*(a + steps * (b - a) for a, b in zip(low, high, strict=True))), axis=-1)
        on_plate = samples.reshape(-1, 2)
        on_plate = on_plate[plate.contains(on_plate)]
        nearest = cKDTree(points).query(on_plate)[1]
        inside = np.any([loop.contains(on_plate) for loop in panel.target_loops], axis=0)
        counted = np.bincount(nearest, minlength=len(points)).astype(float)
        aimed = np.bincount(nearest, weights=inside.astype(float), minlength=len(points))
        area = plate.area * counted / counted.sum()
        share = aimed / np.maximum(counted, 1.0)
        spots = np.array([loop.centroid for loop in panel.target_loops])
        return Grid(points, area, share, (plate.length_x, plate.length_y), panel.target_center, spots)

    @cached_property
    def space(self) -> FieldSpace:
        """Space of the fields at the points: coordinates are the values there."""
        return FieldSpace.of(np.eye(len(self.transfers.points)), self.grid)

    @cached_property
    def reference(self) -> int:
        """Index of the measured temperature nearest to the panel's reference."""
        away = np.abs(self.transfers.temperature - self.panel.filters.reference_temperature)
        return int(np.argmin(away))

    def amplitudes(self, temperature: int) -> Complex:
        """Transfers (N, L, K) at the lines of the panel's settings, at one temperature, by index."""
        return self._at_lines(self.transfers.transfer[temperature])

    def variances(self, temperature: int) -> Real:
        """Variances (N, L, K) of these transfers, E|error|²."""
        return np.maximum(self._at_lines(self.transfers.variance[temperature]).real, 0.0)

    def forms(self, temperature: int, displacement: float) -> tuple[EnergyForms, EnergyForms]:
        """Energy forms for the design, with half the bias of noise, and for the assessment, without it."""
        seen = self.space.forms([self.amplitudes(temperature)], displacement)
        variance = self.variances(temperature)
        noise = [variance @ self.grid.area, variance @ (self.grid.area * self.grid.target)]
        plate, target = (np.eye(len(part))[None, None] * part.T[None, :, :, None] for part in noise)
        design, judged = (
            EnergyForms(inside + outside, inside, seen.aim)
            for inside, outside in (
                (
                    _not_negative(seen.target - share * target),
                    _not_negative(seen.plate - seen.target - share * (plate - target)),
                )
                for share in (0.5, 1.0)
            )
        )
        return design, judged

    def _at_lines(self, values: Complex | Real) -> Complex:
        """Values (N, F, K) at the settings' lines, interpolated linearly."""
        frequency, lines = self.transfers.frequency, self.panel.filters.frequency
        place = np.clip(np.searchsorted(frequency, lines, side="right") - 1, 0, len(frequency) - 2)
        share = np.clip((lines - frequency[place]) / (frequency[place + 1] - frequency[place]), 0.0, 1.0)
        weight = share[None, :, None]
        return np.asarray((1.0 - weight) * values[:, place] + weight * values[:, place + 1], dtype=complex)


def _not_negative(form: Complex) -> Complex:
    """Nearest positive semidefinite form (..., N, N)."""
    values, vectors = np.linalg.eigh(form)
    nearest: Complex = (vectors * np.maximum(values, 0.0)[..., None, :]) @ vectors.conj().swapaxes(-1, -2)
    return nearest


def focus_measured(
    measured: MeasuredPanel,
    method: Method = "stif",
    report: Progress = lambda _stage, _share: None,
    workers: int = 1,
) -> Focusing:
    """Design filters from measured transfers, at the measured temperatures.

    Parameters
    ----------
    method : str
        One of `METHODS`.
    report : callable
        Called with the stage and the share done.
    workers : int
        Threads that design filters.

    Raises
    ------
    ValueError
        For modal control, which needs a model's modes.
    """
    panel, temperature = measured.panel, measured.transfers.temperature
    settings, displacement = panel.filters, panel.target.displacement
    if method == "modal-control":
        raise ValueError("modal-control needs the modes of a model; measured transfers allow the other methods")
    rule = designer(method, NoModes(measured.space), panel, settings.frequency)
    sound = SoundAim.designing(panel, measured.grid, method)

    def answer(t: int) -> Answer:
        amplitude = measured.amplitudes(t)
        forms, judged = measured.forms(t, displacement)
        if sound is not None:
            forms = sound.forms(measured.space, amplitude, forms)
        return Answer(amplitude, forms, judged, rule((0.0, 0.0, 0.0), lambda: amplitude, forms))

    near = measured.reference
    late = method != "stif" and settings.delay is None
    delay = suited_delay(answer(near).wanted[None], settings) if late else settings.middle
    places = [partial(answer, t) for t in range(len(temperature))]
    kept = (float(temperature[near]), places[near])
    design = TapDesign.of(panel, delay)
    heard = sound if panel.filters.aim == "listeners" else SoundAim.judging(panel, measured.grid)
    return design_and_assess(
        panel, measured.space, method, design, temperature, places, kept, report, workers, heard
    )


def compare_measured(measured: MeasuredPanel) -> MethodComparison:
    """Contrast and spot error of every method that needs no model, at the temperature nearest to the reference."""
    panel, space = measured.panel, measured.space
    settings = panel.filters
    lines, band = settings.frequency, settings.in_band(settings.frequency)
    t = measured.reference
    amplitude = measured.amplitudes(t)
    forms, judged = measured.forms(t, panel.target.displacement)
    within, fields = judged.at(slice(None), band), amplitude[:, band]
    methods: tuple[Method, ...] = ("stif", "time-reversal", "none")
    found = []
    for method in methods:
        filters = designer(method, NoModes(space), panel, lines)((0.0, 0.0, 0.0), lambda: amplitude, forms)
        found.append(aim(space, within, fields, filters[band], 1.0))
    contrasts, spots = np.array([one[0] for one in found]), np.array([one[1] for one in found])
    return MethodComparison(methods, (0.0, 0.0, 0.0), lines[band], contrasts, spots)
