"""Filters over temperature, and the filter of one temperature used at all of them (paper 5.1)."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_ascending, check_finite, check_shapes
from analysis.focusing.design import TapDesign, tap_design
from analysis.focusing.energy import EnergyForms, FieldSpace
from analysis.focusing.fir import FirBank, FirEnergy, energy
from analysis.focusing.methods import InverseFilters, Method, designer, invert
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import PanelModel, design_forms, reference_temperature, responses
from analysis.focusing.performance import Aim, Aimed, aim, joined
from analysis.focusing.sound_aim import SoundAim
from analysis.material import MaterialLaws
from analysis.progress import Progress


@dataclass(frozen=True)
class Answer:
    """Response of a panel at one temperature, and the complex filters designed there.

    Attributes
    ----------
    amplitude : (N, F, r) ndarray
    forms, judged : EnergyForms
        For the design and for the assessment; they differ where transfers are measured with noise.
    wanted : (F, N) ndarray
    """

    amplitude: Complex
    forms: EnergyForms
    judged: EnergyForms
    wanted: Complex


@dataclass(frozen=True)
class _Designed:
    """Filters of one temperature, complex and as taps, the panel's inverse, and the aims of `Focusing`."""

    filters: Complex
    taps: Real
    plant: InverseFilters
    uncut: Aimed
    direct: Aimed
    fixed: Aimed


@dataclass(frozen=True)
class Focusing:
    """Filters at some temperatures and their focusing performance.

    Attributes
    ----------
    method, regularisation : str
    tolerance : float
        Of the regularisation, share of the largest singular value.
    temperature : (T,) ndarray
        Degrees Celsius.
    lines : (L,) ndarray
        Where the complex filters are given, Hz: band and tapers.
    frequency : (F,) ndarray
        Lines of the band, Hz, where contrast and spot error are given.
    filters : (T, L, N) ndarray
        Complex filters, V per unit of audio signal.
    rank : (T, L) ndarray
        Number of singular values of H above the tolerance.
    condition : (T, L) ndarray
        Largest over smallest singular value of H.
    bank : FirBank
        The filters as FIR taps.
    energy : FirEnergy
        Distribution of the untruncated filters' energy about the taps.
    uncut, direct, fixed : Aim
        Performance of the complex filters, of the FIR filters of each temperature, and of the FIR filters of
        `reference_temperature` at every temperature.
    reference_temperature : float
        Degrees Celsius.
    target_share : float
        Area of the target over area of the plate: turns a literal contrast into the area-normalised one.
    """

    method: str
    regularisation: str
    tolerance: float
    temperature: Real
    lines: Real
    frequency: Real
    filters: Complex
    rank: NDArray[np.int64]
    condition: Real
    bank: FirBank
    energy: FirEnergy
    uncut: Aim
    direct: Aim
    fixed: Aim
    reference_temperature: float
    target_share: float

    def __post_init__(self) -> None:
        check_shapes(self, temperature="T", lines="L", frequency="F", filters="T L N", rank="T L", condition="T L")
        aims = ("uncut.contrast", "direct.contrast", "fixed.contrast")
        check_shapes(self, temperature="T", frequency="F", **dict.fromkeys(aims, "T F"))
        check_finite(self, "temperature", "lines", "filters")
        check_ascending(self, "lines", "frequency")

    @property
    def rank_changes(self) -> NDArray[np.int64]:
        """Number of lines of the band (T-1,) at which the rank differs between neighbouring temperatures.

        With truncation R is discontinuous there and cannot be interpolated over temperature.
        """
        band = (self.lines >= self.frequency[0]) & (self.lines <= self.frequency[-1])
        changes: NDArray[np.int64] = np.count_nonzero(np.diff(self.rank[:, band], axis=0), axis=1)
        return changes


def focus(
    model: PanelModel,
    panel: Panel,
    laws: MaterialLaws,
    temperature: Real,
    method: Method = "stif",
    report: Progress = lambda _stage, _share: None,
    workers: int = 1,
) -> Focusing:
    """Design filters over temperature, and assess those of the reference temperature at all temperatures.

    Parameters
    ----------
    temperature : (T,) ndarray, °C
    method : str
        One of `METHODS`.
    report : callable
        Called with the stage and the share done.
    workers : int
        Threads that design filters.

    Raises
    ------
    ValueError
        For a material outside the box of the model, or a temperature outside the range of the laws.
    """
    lines, reference = panel.filters.frequency, reference_temperature(panel, laws)
    rule = designer(method, model, panel, lines)
    sound = SoundAim.designing(panel, model.space.grid, method)

    def answer(here: float) -> Answer:
        ((constants, amplitude),) = responses(model, laws, np.array([here]), lines)
        judged = model.forms(*constants, lines, panel.target.displacement)
        forms = design_forms(model, panel, laws, here, judged, sound)
        return Answer(amplitude, forms, judged, rule(constants, lambda: amplitude, forms))

    places = [partial(answer, float(here)) for here in temperature]
    kept = partial(answer, reference)
    design = tap_design(method, model, panel, laws)
    heard = sound if panel.filters.aim == "listeners" else SoundAim.judging(panel, model.space.grid)
    return design_and_assess(
        panel, model.space, method, design, temperature, places, (reference, kept), report, workers, heard
    )


def design_and_assess(
    panel: Panel,
    space: FieldSpace,
    method: Method,
    design: TapDesign,
    temperature: Real,
    places: Sequence[Callable[[], Answer]],
    kept: tuple[float, Callable[[], Answer]],
    report: Progress,
    workers: int,
    sound: SoundAim | None,
) -> Focusing:
    """Design taps for each temperature; assess them and those of the reference temperature.

    Parameters
    ----------
    method : str
        By which the complex filters were designed.
    temperature : (T,) ndarray, °C
    places : sequence of callables
        Each returns the response at one of the temperatures.
    kept : (float, callable)
        Reference temperature, °C, and the response there.
    report : callable
        Called with the stage and the share done.
    workers : int
        Threads that design filters.
    sound : SoundAim or None
        Of the listeners, to be judged.
    """
    settings, lines = panel.filters, panel.filters.frequency
    band, asked = settings.in_band(lines), space.asked(panel.target.displacement)

    def response(taps: Real) -> Complex:
        return np.asarray(design.bank(taps[None], np.zeros(1)).response(lines[band])[0])

    first = kept[1]()
    fixed_filters = response(design.taps(first.forms, first.wanted))

    def at(place: Callable[[], Answer]) -> _Designed:
        here = place()
        taps = design.taps(here.forms, here.wanted)
        plant = invert(here.forms, settings.tolerance, settings.regularisation)
        judged, amplitude = here.judged.at(slice(None), band), here.amplitude[:, band]
        uncut, direct, fixed = (
            aim(space, judged, amplitude, filters, asked, sound)
            for filters in (here.wanted[band], response(taps), fixed_filters)
        )
        return _Designed(here.wanted, taps, plant, uncut, direct, fixed)

    found = []
    with ThreadPoolExecutor(workers) as pool:
        for done, one in enumerate(pool.map(at, places), start=1):
            found.append(one)
            report("Filters", done / len(temperature))
    every = np.array([one.filters for one in found])
    return Focusing(
        method=method,
        regularisation=settings.regularisation,
        tolerance=settings.tolerance,
        temperature=temperature,
        lines=lines,
        frequency=lines[band],
        filters=every,
        rank=np.array([one.plant.rank[0] for one in found]),
        condition=np.array([one.plant.condition[0] for one in found]),
        bank=design.bank(np.array([one.taps for one in found]), temperature),
        energy=energy(every, settings, design.delay),
        uncut=joined([one.uncut for one in found]),
        direct=joined([one.direct for one in found]),
        fixed=joined([one.fixed for one in found]),
        reference_temperature=kept[0],
        target_share=space.grid.target_share,
    )
