"""What leaves Flexura: the report of a run, its filters for other programs, a campaign's raw sweeps."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Literal, get_args

from analysis.recordings.campaign import Campaign
from app.files.campaigns.loading import load_campaign
from app.files.campaigns.sweeps_out import write_sweeps
from app.files.exports.c_code import PREFIX, PREFIXES
from app.files.exports.shipment import shipment
from app.files.exports.written_filters import export_temperatures, same_names, write_filters
from app.files.results.run_folder import is_test_run, run_file, writable_folder
from app.report.written import WrittenReport, write_report
from flexura.arguments import File, as_path, computing, numbers

Form = Literal["c", "onnx", "npz", "wav", "csv"]
SweepForm = Literal["tdms", "mat", "csv", "uff"]


def report(
    run: File, *, out: File | None = None, pictures: bool = False, progress: bool | None = None
) -> WrittenReport:
    """Write everything that was found in a run on one page, as ``flexura report``.

    Parameters
    ----------
    run : path
        Run folder of a campaign or a modal test.
    out : path, optional
        Folder for ``report.html``; the run folder where it is left out.
    pictures : bool
        Write every figure as a PNG file beside it, too.
    progress : bool, optional
        Draw progress bars on the error stream, where that is a terminal, or in a notebook; None: in a notebook.

    Raises
    ------
    app.files.bad_file.ResultFileError
        For a folder without results, or one that cannot be written.
    """
    folder = as_path(run)
    if not is_test_run(folder):
        run_file(folder, "frf.h5", "report")
    target = writable_folder(folder if out is None else as_path(out), "out")
    with computing(shown=progress) as told:
        return write_report(folder, target, told, pictures=pictures)


def export_filters(
    run: File,
    to: Form,
    *,
    method: str | None = None,
    number: Literal["float32", "int16"] = "float32",
    prefix: str = PREFIX,
    tilt: bool = False,
    temperature: float | Sequence[float] = (),
    out: File | None = None,
) -> tuple[Path, ...]:
    """Write the filters of a run so that other programs run them, as ``flexura export``.

    Parameters
    ----------
    run : path
        Run folder with compensation.h5 or filters.h5.
    to : str
        ``c``, ``onnx``, ``npz``, ``wav`` or ``csv``.
    method : str, optional
        How filters follow the temperature; what ``flexura compensate`` recommends where it is left out.
    number, prefix : str
        Numbers of the C code, and the first word of its names.
    tilt : bool
        C code that follows several thermometers, of a run that was judged in a weather.
    temperature : float or sequence of float
        Degrees Celsius, for ``npz``, ``wav`` and ``csv``; every 5 K where it is left out.
    out : path, optional
        Folder for the files; the run folder where it is left out.

    Returns
    -------
    tuple of Path
        Files written.

    Raises
    ------
    ValueError
        For an unknown form or number, a prefix that C does not take, a tilt of another form than ``c``,
        temperatures of a form that follows all, and such that would share the name of a WAV file.
    app.files.bad_file.ResultFileError
        For a folder without such filters, an unknown method, and a temperature that they do not cover.
    """
    if to not in get_args(Form) or number not in ("float32", "int16"):
        raise ValueError(f"to {to!r}, number {number!r}; allowed: {', '.join(get_args(Form))}; float32, int16")
    if not re.fullmatch(PREFIXES, prefix):
        raise ValueError(
            f"prefix {prefix!r}; allowed: a small letter, then at most 30 small letters, digits and _"
        )
    if numbers(temperature) and to in ("c", "onnx"):
        raise ValueError(f"temperature is for npz, wav and csv; {to} follows every temperature")
    if tilt and to != "c":
        raise ValueError(f"tilt of {to!r}; allowed: of 'c'")
    folder = as_path(run)
    sent = shipment(folder, method, "export").chosen(
        {"to": to, "number": number, **({"tilt": True} if tilt else {})}
    )
    wanted = export_temperatures(sent, numbers(temperature), "temperature")
    if to == "wav" and same_names(wanted):
        raise ValueError("temperature: two of them are the same to 0.01 °C, as in the names of WAV files")
    target = writable_folder(folder if out is None else as_path(out), "out")
    return write_filters(sent, to, target, wanted, number=number, prefix=prefix, tilt=tilt)


def export_sweeps(
    campaign: File | Campaign, to: SweepForm, out: File, *, progress: bool | None = None
) -> list[Path]:
    """Write the raw sweeps of a campaign, a file each, as ``flexura export``.

    Parameters
    ----------
    campaign : path or Campaign
        Recorded, imported or acquired; of one that is not complete, the finished sweeps.
    to : str
        ``tdms``, ``mat``, ``csv`` or ``uff``.
    out : path
        Folder for the files.
    progress : bool, optional
        Draw progress bars on the error stream, where that is a terminal, or in a notebook; None: in a notebook.

    Returns
    -------
    list of Path
        Files written.

    Raises
    ------
    ValueError
        For an unknown form, and a campaign of FRFs, which holds no sweeps.
    app.files.campaign_error.CampaignFileError
        For a campaign that cannot be read.
    """
    if to not in get_args(SweepForm):
        raise ValueError(f"to {to!r}; allowed: {', '.join(get_args(SweepForm))}")
    loaded = campaign if isinstance(campaign, Campaign) else load_campaign(as_path(campaign))
    if not isinstance(loaded, Campaign):
        raise ValueError(f"{campaign} holds FRFs and no sweeps")
    folder = writable_folder(as_path(out), "out")
    with computing(shown=progress) as told:
        return list(write_sweeps(loaded, folder, to, told))
