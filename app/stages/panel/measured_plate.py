"""A panel that is declared as the plate that was measured: it takes over what was found about that plate.

E was estimated together with the plate's thickness, mass and lengths: it belongs to these, not to the declared
ones. A panel of another plate of the same material has its own, and E with its whole standard deviation.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from analysis.declaration.transducers import Patch
from analysis.estimates import DeclaredQuantity, Estimate
from analysis.experiment import Experiment
from analysis.focusing.panel import Load, Panel
from app.files.results.best_twin import BestTwin
from app.files.results.frf_file import load_experiment
from app.files.results.twin_file import TwinFile

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
