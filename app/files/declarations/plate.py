"""``plate.toml``: a plate as a campaign declares it, and files with its FRFs instead of time signals."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from analysis.declaration.strict import Declared, FileName, Temperature
from app.files.campaign_error import CampaignFileError
from app.files.settings_toml import checked, read_table

FORMAT = "flexura-plate/1"
NAME = "plate.toml"
NOT_STATED = "not stated"
"""Input module of a plate whose FRFs come as such."""

Level = Annotated[float, Field(gt=0.0, le=1000.0, description="V or N, amplitude of the drive")]
Where = Annotated[str, Field(min_length=1, max_length=200)]


class FrfsOfPlate(Declared):
    """One ``[[frf]]``: files of FRFs, what their channels are, and at which temperature they were measured.

    Texts of `temperature`, `level` and `direction` (but ``up`` and ``down``) name an array of the file: a number,
    or one for each sweep that a ``*`` in a name of `sensors` stands for; of `direction` above 0 for ``down``.
    Where they are left out, `pattern` finds them in the names of files and FRFs.
    """

    file: Annotated[FileName, Field(description="name or pattern, such as frfs/*.uff")]
    temperature: Temperature | Where | None = None
    direction: Where = "up"
    level: Level | Where | None = None
    pattern: Annotated[Where | None, Field(description='such as "{temperature}C_{direction}_{level}V"')] = None
    drive: Annotated[Where | None, Field(description="id of what drove")] = None
    drives: Annotated[dict[str, str], Field(default_factory=dict)]
    sensors: Annotated[dict[str, str], Field(default_factory=dict)]
    coherence: Annotated[dict[str, str], Field(default_factory=dict)]
    frequency: Annotated[Where | None, Field(description="name of the frequencies in the file")] = None
    units: Annotated[tuple[str, str] | None, Field(description="of response and reference")] = None
    averages: Annotated[float | None, Field(ge=1.0, le=1e6, description="of the FRFs")] = None

    @model_validator(mode="after")
    def _one_drive(self) -> Self:
        if self.drive is not None and self.drives:
            raise ValueError("drive and drives are given; keep drive, for all FRFs, or drives, by reference")
        return self


Numbers = Annotated[tuple[Annotated[float, Field(gt=0.0)], ...], Field(min_length=1, max_length=1000)]
Sigma = Annotated[float, Field(gt=0.0)] | Numbers


class ModesOfPlate(Declared):
    """One ``[[modes]]``: natural frequencies at one temperature, or a `file` with a table of them.

    With `damping_ratio` a frequency is |pole| / 2 pi, as of viscous modes; with `loss_factor`, or no damping, it
    is that of a hysteretic mode, sqrt(Re k) / 2 pi.
    """

    file: Annotated[FileName | None, Field(description="CSV beside the declaration")] = None
    temperature: Temperature | None = None
    frequency: Annotated[Numbers | None, Field(description="Hz")] = None
    sigma_frequency: Annotated[Sigma | None, Field(description="Hz")] = None
    damping_ratio: Numbers | None = None
    sigma_damping_ratio: Sigma | None = None
    loss_factor: Numbers | None = None
    sigma_loss_factor: Sigma | None = None
    mode: Annotated[tuple[Annotated[int, Field(ge=1)], ...] | None, Field(description="1: lowest elastic one")] = (
        None
    )

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if (self.file is None) == (self.frequency is None):
            raise ValueError("give either file, or temperature and frequency")
        if self.frequency is None:
            return self
        if self.temperature is None:
            raise ValueError("temperature is missing, °C")
        if self.damping_ratio is not None and self.loss_factor is not None:
            raise ValueError("damping_ratio and loss_factor are given; keep one of them")
        for name in (*SIGMAS, "damping_ratio", "loss_factor", "mode"):
            values = getattr(self, name)
            if isinstance(values, tuple) and len(values) != len(self.frequency):
                raise ValueError(f"{name} has {len(values)} values, frequency {len(self.frequency)}")
        return self


SIGMAS = ("sigma_frequency", "sigma_damping_ratio", "sigma_loss_factor")


class MeasurementOfPlate(Declared):
    """What is known of all FRFs; the temperature is steady unless `ramp_rate` is given."""

    band: Annotated[tuple[float, float] | None, Field(description="Hz")] = None
    ramp_rate: Annotated[float, Field(ge=0.0, le=60.0, description="K/min, magnitude")] = 0.0


class PlateMeasurement(Declared):
    """What the file says besides the plate itself."""

    format: Literal["flexura-plate/1"]
    measurement: MeasurementOfPlate = MeasurementOfPlate()
    frf: Annotated[tuple[FrfsOfPlate, ...], Field(max_length=1000)] = ()
    modes: Annotated[tuple[ModesOfPlate, ...], Field(max_length=1000)] = ()


def plate_file(path: Path) -> Path:
    """Return the declaration: `path` itself, or the file in this folder."""
    return path / NAME if path.is_dir() else path


def declares_plate(path: Path) -> bool:
    """Whether a file, or the ``plate.toml`` in a folder, says that it declares a plate."""
    file = plate_file(path)
    if file.suffix.lower() != ".toml" or not file.is_file():
        return False
    try:
        table: dict[str, Any] = read_table(file)
    except CampaignFileError:
        return file.name == NAME
    return table.get("format") == FORMAT or (file.name == NAME and "format" not in table)


def read_plate_measurement(file: Path) -> tuple[PlateMeasurement, dict[str, Any]]:
    """Read a declaration.

    Returns
    -------
    measurement : PlateMeasurement
        Checked.
    rest : dict
        What it declares of the experiment, unchecked.

    Raises
    ------
    CampaignFileError
        For what is wrong with the measurement.
    """
    table = read_table(file)
    said, rest = _parted(table)
    return checked(file, said, PlateMeasurement), rest


def _parted(table: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    keys = set(PlateMeasurement.model_fields)
    return (
        {key: value for key, value in table.items() if key in keys},
        {key: value for key, value in table.items() if key not in keys},
    )
