"""Material laws of a panel's plate, and their common temperature range with the panel.

A panel that is declared as the plate that was measured: it takes over what was found about that plate.

E was estimated together with the plate's thickness, mass and lengths: it belongs to these, not to the declared
ones. A panel of another plate of the same material has its own, and E with its whole standard deviation.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from analysis.arrays import Real
from analysis.declaration.transducers import Patch
from analysis.estimates import DeclaredQuantity, Estimate
from analysis.experiment import Experiment
from analysis.focusing.panel import Load, Panel
from analysis.focusing.panel_model import covered
from analysis.material import Material, MaterialLaws, MaterialSigma
from analysis.recordings.campaign import CampaignExtent
from app.files.bad_file import ResultFileError
from app.files.campaigns.inputs import origin_of_result, said_of_more_sweeps
from app.files.results.best_twin import CORRECTED, BestTwin, best_twin, recordings
from app.files.results.laws_file import effects_in_laws, laws_elsewhere, load_laws
from app.files.results.modes_file import load_experiment
from app.files.results.twin_file import TwinFile, inputs_digest, read_twin

ON_THE_PANEL = ("point_mass", "sensor_offset")
"""Effects that a panel's declaration can hold: a mass that rides on it, and the place of a patch."""
OF_THE_CAMPAIGN = (
    "thermal_lag",
    "thermal_gradient",
    "draught_gradient",
    "channel_skew",
    "high_pass",
    "feedthrough",
    "piezo_drift",
    "amplitude_softening",
)
"""Effects of the oven, the instruments and the level of the measurement: no part of the plate."""
SAME_PLACE = 1e-6
"""Distance up to which two declared masses are one, m."""


@dataclass(frozen=True)
class MeasuredPlate:
    """What was found about the plate of a campaign.

    Attributes
    ----------
    experiment : Experiment
        As declared.
    departures : mapping of str to mapping of str to float
        True less declared, by declared quantity and parameter, SI.
    effects : mapping of str to tuple of Estimate
    words : mapping of str to str
        Effects for people.
    """

    experiment: Experiment
    departures: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    effects: Mapping[str, Sequence[Estimate]] = field(default_factory=dict)
    words: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of_run(cls, run: Path, best: BestTwin) -> "MeasuredPlate | None":
        """Take it from a run folder; None where frf.h5, which holds the declaration, is not there."""
        path = run / "frf.h5"
        if not path.is_file():
            return None
        words = {name: best.titles.get(name) or name.replace("_", " ") for name in best.effects}
        return cls(load_experiment(path), _departures(best.twin.declared), best.effects, words)

    @classmethod
    def of_twin(cls, twin: TwinFile) -> "MeasuredPlate":
        """Take it from a twin file."""
        effects = {
            one.name: tuple(Estimate(name, p.value, p.sigma, p.unit) for name, p in one.parameter.items())
            for one in twin.effect
        }
        return cls(twin.experiment(), twin.departures, effects, {name: name.replace("_", " ") for name in effects})

    def is_that_of(self, panel: Panel) -> bool:
        """Whether a panel declares this plate: all but the material, which the laws give, and the mesh."""
        declared, ours = (
            plate.model_dump(mode="json", exclude={"material", "mesh"})
            for plate in (panel.plate, self.experiment.plate)
        )
        return declared == ours

    def on(self, panel: Panel) -> tuple[Panel, list[str]]:
        """Return a panel with what was found about its plate, and notes; as it is where it has another plate.

        ValueError where the plate that was found cannot carry the panel's patches.
        """
        if not self.is_that_of(panel):
            stay = [self.words[name] for name in self.effects if name not in OF_THE_CAMPAIGN]
            return panel, [f"{', '.join(stay)}: on the plate that was measured, not on the panel"] if stay else []
        declared = panel.model_dump(mode="json")
        found = [*self._plate(declared["plate"]), *self._patches(declared, panel.patch)]
        loads = self._loads(panel)
        declared["load"] = [load.model_dump(mode="json") for load in (*panel.load, *loads)]
        found += [f"a mass of {1e3 * load.mass:.3g} g at {_at(load.point)}" for load in loads]
        notes = []
        if found:
            notes.append(f"the panel is the plate that was measured, and has what was found: {', '.join(found)}")
        left = [self.words[name] for name in self.effects if name not in (*ON_THE_PANEL, *OF_THE_CAMPAIGN)]
        if left:
            notes.append(
                f"{', '.join(left)}: found on this plate, but the panel's twin cannot hold it, so that filters "
                "reach less on the plate itself"
            )
        return Panel.model_validate_json(json.dumps(declared), strict=True), notes

    def _plate(self, plate: dict[str, Any]) -> list[str]:
        """Put thickness, mass and lengths of the plate into its declaration; what was put in, in words."""
        said = []
        for key, unit, factor in (("thickness", "mm", 1e3), ("mass", "g", 1e3)):
            share = self.departures.get(f"plate_{key}", {}).get("share", 0.0)
            if share:
                plate[key] *= 1.0 + share
                said.append(f"{key} {factor * plate[key]:.5g} {unit}")
        for axis in "xy":
            longer = self._longer(axis)
            if longer:
                plate[f"length_{axis}"] += longer
                said.append(f"length along {axis} {1e3 * plate[f'length_{axis}']:.5g} mm")
        return said

    def _patches(self, declared: dict[str, Any], patches: Sequence[Patch]) -> list[str]:
        """Move every point with the stretched plate; patches that were measured get their place and thickness."""
        known = {one.id: one for one in self.experiment.patch}
        stretched = [1.0 + self._longer(axis) / getattr(self.experiment.plate, f"length_{axis}") for axis in "xy"]
        for table, key in (("patch", "center"), ("drive", "point"), ("load", "point")):
            for one in declared.get(table, ()):
                one[key] = [place * by for place, by in zip(one[key], stretched, strict=True)]
        said = []
        for one, patch in zip(declared.get("patch", ()), patches, strict=True):
            same = known.get(patch.id)
            if same is None or (same.center, same.size, same.thickness) != (
                patch.center,
                patch.size,
                patch.thickness,
            ):
                continue
            moved = self._moved(patch.id)
            one["center"] = [place + by for place, by in zip(one["center"], moved, strict=True)]
            one["thickness"] *= 1.0 + self.departures.get(f"patch_thickness {patch.id}", {}).get("share", 0.0)
            if any(moved):
                said.append(f"{patch.id} at {_at(one['center'])}")
        return said

    def _moved(self, patch: str) -> tuple[float, float]:
        """By how much a patch is off its place along x and y, m."""
        sensors = self.experiment.sensors
        away = dict(self.departures.get(f"patch_place {patch}", {}))
        if sensors and sensors[0].id == patch:
            for one in self.effects.get("sensor_offset", ()):
                away[one.name] = away.get(one.name, 0.0) + one.value
        return away.get("dx", 0.0), away.get("dy", 0.0)

    def _loads(self, panel: Panel) -> list[Load]:
        """Masses that were found, unless the panel has one there."""
        from simulation.shell.points import attached_discs  # not needed where no mass was found

        experiment = self.experiment
        mass = sum(one.value for one in self.effects.get("point_mass", ()))
        if not experiment.cable or mass <= 0.0:
            return []
        (disc,) = attached_discs(experiment.plate, [experiment.cable[0]])
        away = self.departures.get("attachment_place cable 1", {})
        place = (disc.point[0] + away.get("dx", 0.0), disc.point[1] + away.get("dy", 0.0))
        there = [abs(one.point[0] - place[0]) + abs(one.point[1] - place[1]) for one in panel.load]
        if min(there, default=1.0) < SAME_PLACE:
            return []
        return [Load(point=place, radius=disc.radius, mass=mass)]

    def _longer(self, axis: str) -> float:
        """By how much a rectangle is longer than declared, m; other outlines keep their shape."""
        if self.experiment.plate.outline is not None:
            return 0.0
        return self.departures.get(f"plate_length_{axis}", {}).get("longer", 0.0)


def _departures(declared: Sequence[DeclaredQuantity]) -> dict[str, dict[str, float]]:
    found: dict[str, dict[str, float]] = {}
    for one in declared:
        found.setdefault(one.name, {})[one.parameter] = one.value
    return found


def _at(point: Sequence[float]) -> str:
    return ", ".join(f"{1e3 * place:.4g}" for place in point) + " mm"


OWN_SIGMA_SHARE = 0.1
"""Share of a twin file's sigma that each temperature has for itself: a twin file states the whole only, and what
the declaration leaves open, which all temperatures share, is nine tenths of it and more."""


LawsKind = Literal["run", "file", "twin"]


@dataclass(frozen=True)
class PanelLaws:
    """Laws that a panel's plate obeys.

    Attributes
    ----------
    path : Path
        File they stand in.
    laws : MaterialLaws
    folder : Path
        For results.
    notes : tuple of str
        Where they come from, as far as a user has to know it.
    measured : MeasuredPlate or None
        The plate that they were found on; None where only the laws are known.
    uncorrected : MaterialLaws or None
        Those of the plain twin, where `laws` are corrected.
    extent : CampaignExtent or None
        Of the campaign they were found in, where that was not complete.
    kind : str
        ``run``: the best twin of a run folder; ``file`` of laws; ``twin`` file.
    """

    path: Path
    laws: MaterialLaws
    folder: Path
    notes: tuple[str, ...] = ()
    measured: MeasuredPlate | None = None
    uncorrected: MaterialLaws | None = None
    extent: CampaignExtent | None = None
    kind: LawsKind = "run"

    def on(self, panel: Panel) -> tuple[Panel, list[str]]:
        """Return a panel with what was found about its plate, and all notes; ResultFileError if it cannot be."""
        if self.measured is None:
            return panel, list(self.notes)
        try:
            found, notes = self.measured.on(panel)
        except ValueError as error:
            raise ResultFileError(
                f"{self.path}: the plate as it was found cannot carry the panel: {error}; declare another plate"
            ) from error
        return found, [*self.notes, *notes]

    def without_effects(self, temperature: Real) -> MaterialLaws | None:
        """Return the uncorrected laws if they cover temperatures (T,), degrees Celsius."""
        if self.uncorrected is None:
            return None
        low, high = self.uncorrected.temperature_range
        there = low - 1e-9 <= temperature.min() and temperature.max() <= high + 1e-9
        return self.uncorrected if there else None


def laws_for(run: Path | None, twin: Path | None, verb: str) -> PanelLaws:
    """Return the laws of a run's best twin, of a laws file, or of a twin file if one is named.

    Parameters
    ----------
    run : Path or None
        Run folder, or a file of laws; None for the current folder.
    twin : Path or None
        Twin file.
    verb : str
        Name of the calling command, for messages.

    Returns
    -------
    PanelLaws
        Results go into the folder of the laws; with a twin file, or where the folder's laws are elsewhere, into
        `run`, if that is a folder.

    Raises
    ------
    ResultFileError
        Where there are no laws.
    """
    if twin is not None:
        return _of_twin(run, twin)
    run = run or Path()
    if run.is_file():
        return _of_file(run)
    elsewhere = laws_elsewhere(run)
    if elsewhere is not None:
        if elsewhere.twin is not None:
            return _of_twin(run, elsewhere.twin)
        return replace(laws_for(elsewhere.laws, None, verb), folder=run.resolve())
    best = best_twin(run, verb)
    path = best.twin.path.resolve()
    laws = load_laws(path) if best.twin.laws is None else best.twin.laws  # which says why there are none
    plain = None if best.uncorrected is None else best.uncorrected.laws
    extent, said = origin_of(path)
    notes = (*best.notes, *said)
    return PanelLaws(path, laws, path.parent, notes, MeasuredPlate.of_run(run, best), plain, extent)


def origin_of(path: Path) -> tuple[CampaignExtent | None, list[str]]:
    """Return how complete the campaign was in which laws were found, and notes on that; none where it was.

    Parameters
    ----------
    path : Path
        File of the laws.

    Returns
    -------
    extent : CampaignExtent or None
    notes : list of str

    Raises
    ------
    ResultFileError
        Where the file cannot be read.
    """
    verb = "gap" if path.name == CORRECTED else "update"
    origin = origin_of_result(path, verb)
    more = said_of_more_sweeps(path.parent, origin.inputs, verb)
    if more is not None:
        return origin.extent, [f"{path.name}: {more}"]
    return origin.extent, [] if origin.extent is None else [f"{path.name}: {origin.extent.note}"]


def _of_file(path: Path) -> PanelLaws:
    path = path.resolve()
    laws, beside = load_laws(path), path.with_name(CORRECTED)
    notes: tuple[str, ...] = ()
    if path.name != CORRECTED and beside.is_file() and not effects_in_laws(path):
        notes = (
            f"{path.name} is named itself: its laws are uncorrected; name the folder for those of the best twin",
        )
    extent, said = origin_of(path)
    return PanelLaws(path, laws, path.parent, (*notes, *said), extent=extent, kind="file")


def _of_twin(run: Path | None, twin: Path) -> PanelLaws:
    path, read = twin.resolve(), read_twin(twin)
    extent, said = _origin_of_twin(path, read)
    folder = run if run is not None and run.is_dir() else path.parent
    measured = MeasuredPlate.of_twin(read)
    corrected = (f"{twin}: the panel's plate obeys the corrected laws",) if read.effect else ()
    laws, plain = laws_of_twin(read, path), uncorrected_laws(folder)
    return PanelLaws(path, laws, folder, (*corrected, *said), measured, plain, extent, "twin")


def _origin_of_twin(path: Path, twin: TwinFile) -> tuple[CampaignExtent | None, list[str]]:
    """Return how complete a twin file's campaign was, and notes; gap.h5 of the same comparison says so."""
    beside = path.with_name("gap.h5")
    try:
        origin = origin_of_result(beside, "gap") if beside.is_file() else None
    except ResultFileError:  # the twin file does without
        return None, []
    if origin is None or twin.origin.inputs != inputs_digest(recordings(origin.inputs)):
        return None, []
    more = said_of_more_sweeps(path.parent, origin.inputs, "gap")
    if more is not None:
        return origin.extent, [f"{path.name}: {more}"]
    return origin.extent, [] if origin.extent is None else [f"{path.name}: {origin.extent.note}"]


def laws_of_twin(twin: TwinFile, origin: Path) -> MaterialLaws:
    """Smooth laws through the nodes of a twin file; ResultFileError for fewer than three."""
    from analysis.updating.laws import fit_laws

    nodes = twin.laws
    values = (nodes.youngs_modulus, nodes.poisson_ratio, nodes.loss_factor)
    spread = (nodes.sigma_youngs_modulus, nodes.sigma_poisson_ratio, nodes.sigma_loss_factor)
    try:
        material, sigma = Material(*map(np.array, values)), MaterialSigma(*map(np.array, spread))
        common = None
        if twin.departure:
            whole = (sigma.youngs_modulus / material.youngs_modulus, sigma.poisson_ratio)
            columns = np.stack([*whole, sigma.loss_factor / material.loss_factor], axis=1)
            common = np.sqrt(1.0 - OWN_SIGMA_SHARE**2) * columns[:, :, None]
            sigma = MaterialSigma(
                *(OWN_SIGMA_SHARE * x for x in (sigma.youngs_modulus, sigma.poisson_ratio, sigma.loss_factor))
            )
        span = nodes.temperature_range
        return fit_laws(np.array(nodes.temperature), material, sigma, temperature_range=span, common=common)
    except ValueError as error:
        raise ResultFileError(f"{origin}: laws: {error}") from error


def uncorrected_laws(run: Path) -> MaterialLaws | None:
    """Laws that `flexura update` wrote into a run.

    None if there are none, and if they were fitted with effects switched on (`flexura update --twin`), because
    those are corrected.
    """
    try:
        return None if effects_in_laws(run / "laws.h5") else load_laws(run / "laws.h5")
    except ResultFileError:
        return None


def range_of(
    panel: Panel, laws: MaterialLaws, origin: Path, extent: CampaignExtent | None = None
) -> tuple[float, float]:
    """Return the common temperature range of panel and laws.

    Parameters
    ----------
    origin : Path
        File of the laws, for messages.
    extent : CampaignExtent, optional
        Of their campaign, where that was not complete, for messages.

    Returns
    -------
    low, high : float
        Degrees Celsius.

    Raises
    ------
    ResultFileError
        If there is none.
    """
    try:
        return covered(laws, panel.filters.operating_range)
    except ValueError as error:
        of_part = "" if extent is None else f" (this one is not complete: {extent.said})"
        raise ResultFileError(f"{origin}: {error}; update a campaign that covers them{of_part}") from error


def said_of_range(panel: Panel, covered: tuple[float, float]) -> list[str]:
    """Return a note where laws that cover `covered`, °C, do not reach over all of the panel's operating range."""
    low, high = panel.filters.operating_range
    if covered == (low, high):
        return []
    return [
        f"the laws cover {covered[0]:g} to {covered[1]:g} °C only: no filters for the rest of the panel's "
        f"operating_range, {low:g} to {high:g} °C; update a campaign that covers it"
    ]


def within(temperature: Real, laws: MaterialLaws, origin: Path) -> Real:
    """Return temperatures after checking that the laws cover all of them.

    Parameters
    ----------
    temperature : (T,) ndarray
        Degrees Celsius.
    origin : Path
        File of the laws, for messages.

    Returns
    -------
    (T,) ndarray
        `temperature` itself.

    Raises
    ------
    ResultFileError
        If the laws do not cover one, which is named, or if `temperature` is empty.
    """
    if not temperature.size:
        raise ResultFileError(f"{origin}: no temperature is named; at least one is needed")
    low, high = laws.temperature_range
    outside = temperature[~np.isfinite(temperature) | (temperature < low - 1e-9) | (temperature > high + 1e-9)]
    if outside.size:
        raise ResultFileError(
            f"{origin}: --temperature {outside[0]:g} °C is outside the laws' range, {low:g} to {high:g} °C"
        )
    return temperature
