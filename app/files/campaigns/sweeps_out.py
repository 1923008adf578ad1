"""Raw sweeps of a campaign for other programs: TDMS in the recorder's layout, MAT (version 5), CSV, UFF.

A file for each sweep, named as in the campaign's folder. The folder of TDMS files is a recorded campaign with its
``campaign.toml``, which ``flexura import`` reads back bit by bit. The others have a table ``sweeps.csv`` beside
them: step, direction, level, temperatures and time of each file.
"""

import csv
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from analysis.experiment import Experiment
from analysis.progress import Progress
from analysis.recordings.campaign import Campaign, Sweep
from app.files.atomic import atomic_path, write_text
from app.files.bad_file import ResultFileError
from app.files.campaigns.channels import ACTUATOR
from app.files.campaigns.export import campaign_points, direction_of
from app.files.campaigns.kind import DECLARATION
from app.files.campaigns.tdms_file import TdmsLayout
from app.files.campaigns.tdms_sweep import PLATE
from app.files.settings_toml import toml_text
from app.files.uff.frfs import time_text
from app.files.uff.geometry import geometry_text

FORMAT = "recorded-campaign/1"
TABLE = "sweeps.csv"
PROPERTIES = ("step", "direction", "level", "oven_temperature_start", "oven_temperature_end", "start_time")


def write_sweeps(campaign: Campaign, folder: Path, form: str, report: Progress) -> tuple[Path, ...]:
    """Write every sweep of a campaign, and what says what they are.

    Parameters
    ----------
    folder : Path
        It is made if need be.
    form : str
        One of `SWEEP_FORMS`.
    report : callable
        Called with the stage's name and the share done.

    Returns
    -------
    tuple of Path
        All files.

    Raises
    ------
    ResultFileError
        Rather than replace a declaration that is there.
    """
    experiment, written = campaign.experiment, []
    if form == "tdms":
        declaration = folder / DECLARATION
        if declaration.exists():
            raise ResultFileError(f"{declaration}: is there already; name another folder with --out")
        table = {"format": FORMAT, **experiment.model_dump(mode="json", exclude_none=True, exclude_defaults=True)}
        write_text(declaration, toml_text(table, f"Of the campaign {campaign.name}, written by flexura export."))
        written.append(declaration)
    for done, sweep in enumerate(campaign.sweeps):
        report("sweeps", done / len(campaign.sweeps))
        name = f"{sweep.step:04d}_{sweep.direction}_T{sweep.temperature:+06.1f}.{form}"
        path = (folder / "sweeps" if form == "tdms" else folder) / name
        with atomic_path(path) as partial:
            SWEEP_FORMS[form](partial, sweep, experiment)
        written.append(path)
    if form != "tdms":
        write_text(folder / TABLE, _table(campaign, [path.name for path in written]))
        written.append(folder / TABLE)
    report("sweeps", 1.0)
    return tuple(written)


def _properties(sweep: Sweep, experiment: Experiment) -> dict[str, Any]:
    found = {name: getattr(sweep, name) for name in (*PROPERTIES, *PLATE) if getattr(sweep, name) is not None}
    if len(experiment.inputs) > 1:
        found[ACTUATOR] = experiment.inputs[sweep.source].id
    return found


def _channels(sweep: Sweep) -> list[Any]:
    """Return the repeats (R, M) of every channel, the drive's first."""
    return [sweep.drive, *sweep.responses]


def _write_tdms(path: Path, sweep: Sweep, experiment: Experiment) -> None:
    from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

    layout = TdmsLayout.of(experiment, sweep.source)
    waveform = {"wf_increment": 1.0 / layout.rate, "wf_start_offset": 0.0, "wf_samples": sweep.drive.shape[1]}
    with TdmsWriter(path) as writer:
        writer.write_segment([RootObject(_properties(sweep, experiment))])
        for repeat, group in enumerate(layout.groups[: len(sweep.drive)]):
            objects = [GroupObject(group)]
            for channel, unit, samples in zip(layout.channels, layout.units, _channels(sweep), strict=True):
                values = np.ascontiguousarray(samples[repeat], dtype=np.float32)
                objects.append(ChannelObject(group, channel, values, {**waveform, "unit_string": unit}))
            writer.write_segment(objects)


def _write_mat(path: Path, sweep: Sweep, experiment: Experiment) -> None:
    from scipy.io import savemat

    layout = TdmsLayout.of(experiment, sweep.source)
    values = {
        **_properties(sweep, experiment),
        "sample_rate": layout.rate,
        "channels": np.array(layout.channels, dtype=object),
        "units": np.array(layout.units, dtype=object),
        "drive": sweep.drive,  # repeat by sample
        "responses": sweep.responses,  # sensor by repeat by sample
    }
    content = io.BytesIO()  # given a name, it would add an ending
    savemat(content, values, do_compression=True, oned_as="column")  # type: ignore[arg-type]
    path.write_bytes(content.getvalue())


def _write_uff(path: Path, sweep: Sweep, experiment: Experiment) -> None:
    """Write header, nodes, and a time response (data set 58) of every channel, repeat after repeat.

    Nodes are those of exported FRFs: outputs, then inputs.
    """
    layout, outputs = TdmsLayout.of(experiment, sweep.source), experiment.outputs
    drive = experiment.inputs[sweep.source]
    placed = [(len(outputs) + 1 + sweep.source, drive), *enumerate(outputs, start=1)]
    parts = [geometry_text(experiment.title, campaign_points(experiment))]
    parts += [
        time_text(name, f"{node}:{direction_of(channel)}", channel.quantity, unit, one[repeat], 1.0 / layout.rate)
        for repeat in range(len(sweep.drive))
        for (node, channel), name, unit, one in zip(
            placed, layout.channels, layout.units, _channels(sweep), strict=True
        )
    ]
    path.write_text("".join(parts), encoding="utf-8", newline="\n")


def _write_csv(path: Path, sweep: Sweep, experiment: Experiment) -> None:
    layout = TdmsLayout.of(experiment, sweep.source)
    repeats, samples = sweep.drive.shape
    names = [
        f"{channel} {repeat + 1} [{unit}]"
        for repeat in range(repeats)
        for channel, unit in zip(layout.channels, layout.units, strict=True)
    ]
    columns = [one[repeat] for repeat in range(repeats) for one in _channels(sweep)]
    time = np.arange(samples) / layout.rate
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerow(["time [s]", *names])
        # nine digits are all that a float32 has, and times of 1e5 samples keep theirs
        np.savetxt(file, np.column_stack([time, *columns]), fmt=["%.12g", *["%.9g"] * len(columns)], delimiter=",")


def _table(campaign: Campaign, names: list[str]) -> str:
    """Return the table of all sweeps, of files that do not say it themselves."""
    rows = [_properties(sweep, campaign.experiment) for sweep in campaign.sweeps]
    heads = list(dict.fromkeys(key for row in rows for key in row))
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["file", *heads])
    writer.writerows([name, *(row.get(key, "") for key in heads)] for name, row in zip(names, rows, strict=True))
    return stream.getvalue()


SWEEP_FORMS: dict[str, Callable[[Path, Sweep, Experiment], None]] = {
    "tdms": _write_tdms,
    "mat": _write_mat,
    "csv": _write_csv,
    "uff": _write_uff,
}
