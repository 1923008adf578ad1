"""``test.toml``: files of a modal test, what their channels are, and how FRFs are made of them."""

from datetime import date as Date  # noqa: N812 (the field is called date)
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from analysis.channel import Quantity
from analysis.declaration.strict import Declared, FileName, Temperature
from analysis.estimation.estimators import Estimator
from analysis.estimation.impacts import HammerTest
from analysis.estimation.quantities import Calibration, calibration
from analysis.estimation.windows import Shape
from analysis.recordings.grid_frequency import MAINS_RANGE
from app.files.campaign_error import CampaignFileError
from app.files.settings_toml import checked, read_table

FORMAT = "flexura-test/1"
NAME = "test.toml"
MEASURED = ("drive", "response")
AXES = {"x": 1, "y": 2, "z": 3}

Place = Annotated[
    str,
    Field(pattern=r"^[1-9][0-9]{0,6}(:[+-][xyz])?$", description='node and direction, as "5:+z"; +z unless given'),
]
Node = Annotated[str, Field(pattern=r"^[1-9][0-9]{0,6}$")]
Role = Literal[
    "drive", "response", "time", "frequency", "frf", "real", "imaginary", "magnitude", "phase", "coherence",
    "unused",
]  # fmt: skip
PARTS: tuple[tuple[Role, Role], ...] = (("real", "imaginary"), ("magnitude", "phase"))
"""Roles of two columns that are one FRF."""


class ChannelOfFile(Declared):
    """One column of the files: what it is, and how its numbers become a quantity."""

    role: Role
    unit: str | None = None
    sensitivity: str | None = None
    quantity: Quantity | None = None
    at: Place | None = None
    reference: Place | None = None
    full_scale: Annotated[float | None, Field(gt=0.0, description="largest value in the file's unit")] = None
    start: Annotated[float | None, Field(description="s, of the first sample, instead of the file's")] = None

    def calibration(self, file_unit: str | None) -> Calibration:
        """Return what its numbers mean; ValueError, with what to write, where that is not known."""
        unit = self.unit or file_unit
        if unit is None:
            raise ValueError('the file gives no unit; give unit, for example unit = "V" with a sensitivity')
        return calibration(unit, self.sensitivity, self.quantity)


class RecordOfTest(Declared):
    """One file, or one `group` of a file's channels; `at` names the places of channels that were moved for it."""

    file: FileName
    group: str = ""
    at: Annotated[dict[str, Place], Field(default_factory=dict)]

    @property
    def name(self) -> str:
        """File and group, for messages."""
        return f"{self.file} {self.group}".rstrip()


class HammerSettings(Declared):
    """See `analysis.estimation.impacts.HammerTest`."""

    trigger: Annotated[float | None, Field(gt=0.0, description="N")] = None
    pretrigger: Annotated[float | None, Field(ge=0.0, le=10.0, description="s")] = None
    duration: Annotated[float | None, Field(gt=0.0, le=1000.0, description="s")] = None
    double_hit: Annotated[float, Field(gt=0.0, le=1.0, description="share of the first peak")] = 0.1
    force_window: bool = True
    exponential: Annotated[float, Field(gt=0.0, le=1.0, description="at the end of a block; 1: none")] = 1.0
    coupling: Annotated[
        float | None, Field(gt=0.0, le=100.0, description="Hz, corner of the AC coupling of all channels")
    ] = None

    def test(self) -> HammerTest:
        """Return the settings as the computation takes them; ValueError where they do not fit each other."""
        return HammerTest(**self.model_dump())


class SegmentSettings(Declared):
    """Welch's segments, of signals that go on."""

    seconds: Annotated[float, Field(gt=0.0, le=10000.0, description="s; lines lie 1/seconds apart")] = 2.0
    window: Shape = "hann"
    overlap: Annotated[float, Field(ge=0.0, le=0.95)] = 0.5


class FrfSettings(Declared):
    """Of FRFs that come as such."""

    response: str = "m/s2"
    reference: str = "N"


class ModalTest(Declared):
    """The whole declaration."""

    format: Literal["flexura-test/1"]
    title: str = ""
    operator: str = ""
    date: Date | None = None
    kind: Literal["hammer", "continuous", "frf"]
    estimator: Estimator = "h1"
    sample_rate: Annotated[float, Field(gt=0.0, le=1e9, description="Hz")] | str | None = None
    temperature: Temperature | None = None
    mains: Annotated[float | None, Field(ge=MAINS_RANGE[0], le=MAINS_RANGE[1], description="Hz")] = None
    channels: Annotated[dict[str, ChannelOfFile], Field(min_length=1)]
    record: Annotated[tuple[RecordOfTest, ...], Field(min_length=1)]
    points: Annotated[dict[Node, tuple[float, float, float]], Field(default_factory=dict)]
    hammer: HammerSettings = HammerSettings()
    segments: SegmentSettings = SegmentSettings()
    frf: FrfSettings = FrfSettings()

    @model_validator(mode="after")
    def _roles_of_its_kind(self) -> Self:
        roles = [channel.role for channel in self.channels.values()]
        if self.kind == "frf":
            single = any(roles.count(one) == roles.count(other) == 1 for one, other in PARTS)
            if roles.count("frequency") != 1 or not (single or "frf" in roles):
                raise ValueError(
                    'kind "frf": one channel with the role frequency is needed, and either complex ones with the '
                    "role frf, or one real and one imaginary, or one magnitude and one phase"
                )
        elif "drive" not in roles or "response" not in roles:
            raise ValueError(
                f'kind "{self.kind}": at least one channel with the role drive and one with the role response are '
                f"needed; there are {', '.join(sorted(set(roles)))}"
            )
        if self.kind == "hammer" and roles.count("drive") > 1:
            raise ValueError('kind "hammer": one channel with the role drive; make the others unused')
        strangers = sorted({name for record in self.record for name in record.at} - {*self.channels, *ENDS})
        if strangers:
            raise ValueError(
                f"record.at names {strangers[0]!r}, which is no channel; there are {[*self.channels]}"
            )
        try:
            self.hammer.test()
        except ValueError as error:
            raise ValueError(f"hammer: {error}") from error
        return self


ENDS = ("response", "reference")
"""What `record.at` names of an FRF with one real and one imaginary part."""


def read_modal_test(path: Path) -> ModalTest:
    """Read a declaration; CampaignFileError with everything that is wrong with it."""
    return checked(path, read_table(path), ModalTest)


def declares_test(path: Path) -> bool:
    """Whether a file, or the ``test.toml`` in a folder, says that it declares a modal test."""
    file = path / NAME if path.is_dir() else path
    if file.suffix.lower() != ".toml" or not file.is_file():
        return False
    try:
        table: dict[str, Any] = read_table(file)
    except CampaignFileError:
        return file.name == NAME
    return table.get("format") == FORMAT


def dof(place: str) -> str:
    """Return a place as universal files have it: ``5:+z`` is ``5:+3``."""
    node, _, direction = place.partition(":")
    return f"{node}:{direction[0]}{AXES[direction[1]]}" if direction else f"{node}:+3"
