"""``[channels]`` and ``[sweeps]`` of a campaign: what is what in TDMS files of a recorder's own layout."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field

from analysis.channel import Channel
from analysis.declaration.strict import Declared, Temperature
from analysis.estimation.quantities import Calibration, calibration
from analysis.experiment import Experiment
from app.files.campaign_error import Problem

ACTUATOR = "actuator"
"""Root property that names what drove a sweep."""
KEYS = ("channels", "sweeps")
"""Of ``campaign.toml``, beside what is declared of the experiment."""


class RecordedChannel(Declared):
    """A channel of the recorder's files: what it measures, and how its numbers become SI units."""

    role: Literal["drive", "response", "unused"]
    at: Annotated[str | None, Field(description="id of its patch, drive or sensor")] = None
    unit: str | None = None
    sensitivity: str | None = None

    def calibration(self, file_unit: str | None, measures: Channel) -> Calibration:
        """Return what its numbers mean; ValueError, with what to write, where that is not known."""
        unit = self.unit or file_unit
        if unit is None:
            raise ValueError('the file gives no unit; give unit, for example unit = "V"')
        return calibration(unit, self.sensitivity, measures.quantity)


class RecordedSweep(Declared):
    """What is known of one file besides its channels."""

    temperature: Annotated[Temperature | tuple[Temperature, Temperature], Field(description="or start and end")]
    direction: Literal["up", "down"] = "up"
    level: Annotated[float, Field(gt=0.0, le=1000.0, description="V or N, amplitude of the drive")]
    start_time: str | None = None
    actuator: Annotated[str | None, Field(description="id of what drove, where several drove in turn")] = None


class RecorderLayout(Declared):
    """Both tables; empty where the files have the layout that Flexura asks for."""

    channels: Annotated[dict[str, RecordedChannel], Field(default_factory=dict)]
    sweeps: Annotated[dict[str, RecordedSweep], Field(default_factory=dict)]

    def properties(self, file: str, of_file: Mapping[str, Any]) -> dict[str, Any]:
        """Root properties of a file, with what ``[sweeps]`` says of it; its place there is its step."""
        if file not in self.sweeps:
            return dict(of_file)
        said = self.sweeps[file]
        ends = said.temperature if isinstance(said.temperature, tuple) else (said.temperature, said.temperature)
        known = {
            "oven_temperature_start": ends[0],
            "oven_temperature_end": ends[1],
            "direction": said.direction,
            "level": said.level,
            "step": list(self.sweeps).index(file),
            **({ACTUATOR: said.actuator} if said.actuator else {}),
        }
        start = said.start_time or of_file.get("start_time") or of_file.get("DateTime")
        return {**of_file, **known, **({"start_time": start} if start else {})}

    def wired(self, experiment: Experiment, source: int = 0) -> dict[str, tuple[str, RecordedChannel]]:
        """Find the recorder's channel of each of the experiment's, by identifier; ValueError says what is missing.

        Parameters
        ----------
        source : int
            Which of its inputs drives; the drive's channels of the others are passed over.

        Returns
        -------
        dict
            Identifier to the name in the files and what is declared of it; the drive first.
        """
        found: dict[str, tuple[str, RecordedChannel]] = {}
        driving, idle = (
            experiment.inputs[source],
            {one.id for k, one in enumerate(experiment.inputs) if k != source},
        )
        for role, wanted in (("drive", (driving,)), ("response", experiment.outputs)):
            ours = [one.id for one in wanted]
            theirs = {name: one for name, one in self.channels.items() if one.role == role and one.at not in idle}
            for name, one in theirs.items():
                place = one.at or (ours[0] if len(ours) == len(theirs) == 1 else None)
                if place not in ours:
                    raise ValueError(
                        f'{name!r} has role = "{role}" and at = {one.at!r}; at has to be one of {", ".join(ours)}'
                    )
                if place in found:
                    raise ValueError(
                        f'{name!r} and {found[place][0]!r} both have at = "{place}"; one of them is unused'
                    )
                found[place] = (name, one)
            lacking = [one for one in ours if one not in found]
            if lacking:
                raise ValueError(
                    f'no channel for {", ".join(lacking)}; add one with role = "{role}", at = "{lacking[0]}"'
                )
        return {one.id: found[one.id] for one in (driving, *experiment.outputs)}

    def problems(self, file: str, experiment: Experiment, tdms_files: list[str]) -> list[Problem]:
        """Say what in both tables does not fit the experiment, or the files there are.

        Parameters
        ----------
        file : str
            Of the declaration.
        tdms_files : list of str
            Names of the files in the folder of sweeps.
        """
        problems = []
        if self.channels:
            try:
                for source in range(len(experiment.inputs)):
                    self.wired(experiment, source)
            except ValueError as error:
                problems.append(Problem(file, "channels", str(error), ""))
        there = ", ".join(tdms_files[:8]) or "none"
        problems += [
            Problem(file, f'sweeps."{name}"', "no such file", f"one of the folder sweeps: {there}")
            for name in self.sweeps
            if name not in tdms_files
        ]
        return problems
