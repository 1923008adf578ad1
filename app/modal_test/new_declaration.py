"""A declaration to start from: of a test, after a look into its files, or of a campaign, after the shipped one."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from app.files.atomic import write_text
from app.files.bad_file import ResultFileError
from app.files.campaign_kind import DECLARATION
from app.files.measurements.guarded import read_columns
from app.files.modal_test_toml import FORMAT, ModalTest
from app.files.settings_toml import checked, read_table
from app.files.shipped import shipped
from app.files.toml_text import toml_text
from app.modal_test.guessed_channels import NewTest, guessed_channels, guessed_rate, lacks_sensitivity
from app.modal_test.points_table import points_of_table

TEST_HEAD = """What this test is; see the guide, "A modal test". Correct what was guessed:
role: drive, response, time, frequency, frf, real, imaginary, coherence, unused
sensitivity: what the sensor gives, "100 mV/g" or "2.25 mV/N"; left out where the file holds the unit itself
at: node and direction, "5:+z"; [points] gives nodes their places in metres"""

CAMPAIGN_HEAD = """A recorded campaign, after the example that comes with Flexura: replace its numbers by yours
(guide, "A recorded campaign"), and put one TDMS file for each temperature into sweeps/."""


def new_test(files: Sequence[Path], said: NewTest, target: Path) -> tuple[ModalTest, list[str]]:
    """Write a test's declaration.

    Parameters
    ----------
    files : sequence of Path
        Measurements; the first is looked into.
    said : NewTest
    target : Path
        File to write.

    Returns
    -------
    declared : ModalTest
    missing : list of str
        Channels in volts without a sensitivity, to be completed by hand.

    Raises
    ------
    ResultFileError
        For files that cannot be read, and channels named that are not there.
    CampaignFileError
        Where what was said and guessed makes no test.
    """
    if not files:
        raise ResultFileError("no file named; type: flexura new test FILE ...")
    columns = read_columns(files[0])
    channels = guessed_channels(files[0], columns, said)
    roles = [str(channel["role"]) for channel in channels.values()]
    kind = said.kind or ("frf" if "frequency" in roles else "hammer")
    if kind != "frf" and "drive" not in roles:
        raise ResultFileError(
            f"{files[0]}: none of its channels is called like a drive; name it with --drive NAME=SENSITIVITY. It "
            f"holds: {', '.join(list(columns.values)[:20])}"
        )
    nodes = 0
    for channel in channels.values():
        if channel["role"] in ("response", "frf"):
            nodes += 1
            channel["at"] = f"{nodes}:+z"
        elif channel["role"] == "drive":
            channel["at"] = "1:+z"
    table: dict[str, Any] = {"format": FORMAT, "title": said.title or target.resolve().parent.name, "kind": kind}
    table |= guessed_rate(columns, said, roles) | {"channels": channels}
    if kind == "hammer":
        table["hammer"] = {"pretrigger": 0.005, "exponential": 1.0}
    elif kind == "continuous":
        table["segments"] = {"seconds": 2.0, "window": "hann", "overlap": 0.5}
    else:
        table["frf"] = dict(zip(("response", "reference"), said.frf_units or ("m/s2", "N"), strict=True))
    folder = target.resolve().parent
    table["record"] = [
        {"file": Path(os.path.relpath(file.resolve(), folder)).as_posix()}
        | ({"at": {said.roving: f"{number}:+z"}} if said.roving else {})
        for number, file in enumerate(files, start=1)
    ]
    if said.points is not None:
        table["points"] = points_of_table(said.points)
    declared = checked(target, table, ModalTest)
    _write(target, toml_text(table, TEST_HEAD))
    return declared, [name for name, one in channels.items() if lacks_sensitivity(one, columns.units.get(name))]


def new_campaign(target: Path, plate: tuple[float, float, float, float] | None, title: str) -> Path:
    """Write ``campaign.toml`` into the folder `target`, or as the file of that name.

    Parameters
    ----------
    target : Path
    plate : (float, float, float, float) or None
        Length along x and y, thickness, m, and mass, kg; None for those of the example.
    title : str
        Empty for that of the folder.

    Returns
    -------
    Path
        Of the file.

    Raises
    ------
    ResultFileError
        Where there is a declaration already.
    """
    file = target if target.suffix == ".toml" else target / DECLARATION
    if file.exists():
        raise ResultFileError(f"{file}: is there already; name another with --out, or remove it")
    table = read_table(shipped("pp-plate") / DECLARATION)
    table["title"] = title or file.resolve().parent.name
    if plate is not None:
        table["plate"] |= dict(zip(("length_x", "length_y", "thickness", "mass"), plate, strict=True))
    _write(file, toml_text(table, CAMPAIGN_HEAD))
    return file


def _write(target: Path, text: str) -> None:
    try:
        write_text(target, text)
    except OSError as error:
        raise ResultFileError(
            f"{target}: cannot be written ({error.strerror}); name another with --out"
        ) from error
