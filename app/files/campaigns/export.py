"""FRFs of a campaign for other programs: universal files, MAT, CSV and netCDF.

Beside every FRF h goes the coherence that belongs to its variance v, of n averages:

    c = |h|^2 / (|h|^2 + (n - 1) v),

so that a program that takes v = |h|^2 (1 - c) / ((n - 1) c) from it (Bendat and Piersol, Random Data, 2010, ch. 9)
has the noise that Flexura found, smooth over frequency and free of the oven's drift.

Universal files have nodes, directions and quantities in place of channels.
"""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from analysis.arrays import Real
from analysis.channel import Channel
from analysis.estimation.transfer import MeasuredTransfer
from analysis.experiment import Experiment
from analysis.recordings.frf import Frf
from app.files.atomic import atomic_path, write_text
from app.files.bad_file import ResultFileError
from app.files.campaigns.kind import EXPORTS
from app.files.uff.frfs import DOUBLE_REAL, frf_text
from app.files.uff.geometry import geometry_text

MAT_HEAD = b"MATLAB 5.0 MAT-file, FRFs of a campaign, written by Flexura"
"""First bytes of a MAT file, instead of the time of day that scipy writes there."""
COHERENCE_FUNCTION = 6


def export_frfs(target: Path, experiment: Experiment, frf: Frf, sweep: int | None = None) -> list[Path]:
    """Write FRFs in the format that the ending of `target` says.

    Parameters
    ----------
    target : Path
        Universal file, MAT file, netCDF file, or CSV: of several sweeps one each, with the sweep in its name.
    sweep : int, optional
        The only one, from 0.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    ResultFileError
        For another ending.
    OSError
        Where a file cannot be written.
    """
    wanted = [*range(len(frf.temperature))] if sweep is None else [sweep]
    if target.suffix.lower() in (".uff", ".unv"):
        write_text(target, _universal(experiment, frf, wanted))
        return [target]
    if target.suffix.lower() == ".mat":
        _write_mat(target, experiment, frf, wanted)
        return [target]
    if target.suffix.lower() == ".csv":
        return _write_csv(target, experiment, frf, wanted, alone=sweep is not None)
    if target.suffix.lower() == ".nc":
        _write_netcdf(target, experiment, frf, wanted)
        return [target]
    raise wrong_ending(target)


def wrong_ending(target: Path) -> ResultFileError:
    """Say which endings an export can have."""
    return ResultFileError(f"--export {target}: ending {target.suffix!r}; allowed: {', '.join(EXPORTS)}")


def averages(frf: Frf, sweep: int) -> int:
    """Return n of the module's formula: the repeats of a sweep, 2 where they are not known."""
    dof = 0 if frf.repeats_dof is None else int(frf.repeats_dof[sweep])
    return dof // 2 + 1 if dof >= 2 else 2


def stated_coherence(frf: Frf, sweep: int) -> Real:
    """Return the coherence (K, F) that belongs to the variance of a sweep's FRFs."""
    power = np.abs(frf.h[sweep]) ** 2
    noise = (averages(frf, sweep) - 1) * frf.variance[sweep]
    return np.asarray(power / np.maximum(power + noise, np.finfo(float).tiny))


RANGE_MARGIN = 1.0
"""K that a temperature asked for may lie beyond those measured: readings differ from the temperatures declared."""


def campaign_frfs(experiment: Experiment, frf: Frf, sweep: int | None = None) -> list[MeasuredTransfer]:
    """Return a sweep's FRFs, or every sweep's, sweep by sweep, with names that distinguish them.

    Parameters
    ----------
    sweep : int, optional
        The only one, from 0.
    """
    inputs, outputs = experiment.inputs, experiment.outputs
    return [
        MeasuredTransfer(
            name=f"{label} {sweep_name(frf, number)}",
            response=f"{node}:{direction_of(output)}",
            reference=f"{len(outputs) + 1 + which}:{direction_of(source)}",
            quantity=output.quantity,
            frequency=frf.frequency,
            h=h,
            reference_quantity=source.quantity,
            units=(output.unit, source.unit),
        )
        for number, which in enumerate(frf.driven_by)
        if sweep in (None, number)
        for source in (inputs[which],)
        for node, (output, label, h) in enumerate(
            zip(outputs, experiment.labels(source), frf.h[number], strict=True), start=1
        )
    ]


def campaign_points(experiment: Experiment) -> dict[int, tuple[float, float, float]]:
    """Return where forces act and motions are read, m, by node; a patch is no point and has none."""
    channels = enumerate((*experiment.outputs, *experiment.inputs), start=1)
    return {node: (*one.footprint.point, 0.0) for node, one in channels if one.footprint is not None}


def sweep_name(frf: Frf, sweep: int) -> str:
    """Say which sweep it is: ``20.01 C up 0.3 V``."""
    level = f"{frf.level[sweep]:g} {frf.level_unit(sweep)}"
    return f"{frf.temperature[sweep]:.2f} C {frf.direction[sweep]} {level}"


def nearest_sweep(frf: Frf, temperature: float) -> int:
    """Return the sweep nearest to a temperature in degrees Celsius, the first of several.

    Raises ValueError where the campaign was not measured there.
    """
    low, high = float(frf.temperature.min()), float(frf.temperature.max())
    if not low - RANGE_MARGIN <= temperature <= high + RANGE_MARGIN:
        raise ValueError(f"--temperature {temperature:g} °C; the sweeps are from {low:.2f} to {high:.2f} °C")
    return int(np.argmin(np.abs(frf.temperature - temperature)))


def direction_of(channel: Channel) -> str:
    """Return the direction of a channel: ``+3`` out of the top face, ``+0`` of a patch."""
    return "+0" if channel.footprint is None else f"{3 * round(channel.footprint.along):+d}"


def _universal(experiment: Experiment, frf: Frf, wanted: list[int]) -> str:
    parts = [geometry_text(experiment.title, campaign_points(experiment))]
    for sweep in wanted:
        transfers = campaign_frfs(experiment, frf, sweep)
        parts += [frf_text(one) for one in transfers]
        parts += [_coherence_text(*pair) for pair in zip(transfers, stated_coherence(frf, sweep), strict=True)]
    return "".join(parts)


def _coherence_text(frf: MeasuredTransfer, coherence: Real) -> str:
    """Return a data set 58 of function type 6, after the FRF's own: the same ends and lines, real values."""
    lines = frf_text(frf).splitlines()
    head, axes = lines[:7], lines[8:12]
    head += [f"{COHERENCE_FUNCTION:5d}{lines[7][5:]}"]
    abscissa = axes[0]
    even = int(abscissa[20:30])
    form = f"{DOUBLE_REAL:10d}{abscissa[10:]}"
    # the first line after the function's is the abscissa's form, then the axes: frequency, ordinate, denominator
    values = [f"{value:20.12e}" for value in coherence]
    if even:
        rows = ["".join(values[n : n + 4]) for n in range(0, len(values), 4)]
    else:
        rows = [line[:13] + value for line, value in zip(lines[13:-1], values, strict=True)]
    unitless = f"{0:10d}{axes[1][10:26]}{'NONE':20} {'NONE':20}"  # no exponents of length, force or temperature
    return "\n".join([*head, form, lines[9], unitless, unitless, lines[12], *rows, lines[-1]]) + "\n"


def _write_mat(target: Path, experiment: Experiment, frf: Frf, wanted: list[int]) -> None:
    """Write ``H_SENSOR`` and ``coherence_SENSOR`` (T, F), and temperatures; of several drives, each its own."""
    from scipy.io import savemat  # takes a second to import

    driven = frf.driven_by
    held: dict[str, Any] = {"frequency": frf.frequency}
    for source in sorted({int(driven[sweep]) for sweep in wanted}):
        rows = [sweep for sweep in wanted if driven[sweep] == source]
        behind = f"_{_word(experiment.inputs[source].id)}" if len(frf.driving) > 1 else ""
        held |= {
            f"temperature{behind}": frf.temperature[rows],
            f"level{behind}": frf.level[rows],
            f"descending{behind}": np.array([float(frf.direction[sweep] == "down") for sweep in rows]),
            f"averages{behind}": np.array([float(averages(frf, sweep)) for sweep in rows]),
        }
        coherence = np.array([stated_coherence(frf, sweep) for sweep in rows])
        for row, name in enumerate(frf.channels):
            held[f"H_{_word(name)}{behind}"] = frf.h[rows][:, row]
            held[f"coherence_{_word(name)}{behind}"] = coherence[:, row]
    with atomic_path(target) as partial:
        savemat(partial, held, appendmat=False, oned_as="row")
        with partial.open("r+b") as file:
            file.write(MAT_HEAD.ljust(116))


def _write_netcdf(target: Path, experiment: Experiment, frf: Frf, wanted: list[int]) -> None:
    """Write a netCDF-3 file for ``xarray.open_dataset``: real and imaginary part by sweep, sensor, frequency.

    The format has no complex numbers and no texts; sensors are rows of letters. By the CF conventions temperature,
    level and direction are coordinates of the sweeps.
    """
    from scipy.io import netcdf_file  # takes a second to import

    of_sweeps = {
        "temperature": (frf.temperature[wanted], "degree_Celsius"),
        "level": (frf.level[wanted], " or ".join(dict.fromkeys(frf.level_unit(sweep) for sweep in wanted))),
        "descending": (np.array([float(frf.direction[sweep] == "down") for sweep in wanted]), "1"),
        "averages": (np.array([float(averages(frf, sweep)) for sweep in wanted]), "1"),
        "source": (frf.driven_by[wanted].astype(float), "1"),
    }
    h = frf.h[wanted]
    units = " or ".join(
        dict.fromkeys(frf.unit(row, sweep) for sweep in wanted for row in range(len(frf.channels)))
    )
    fields = {
        "h_real": (h.real, units),
        "h_imag": (h.imag, units),
        "variance": (frf.variance[wanted], f"({units})^2"),
        "coherence": (np.array([stated_coherence(frf, sweep) for sweep in wanted]), "1"),
    }
    letters = max(len(name.encode()) for name in frf.channels)
    with atomic_path(target) as partial, netcdf_file(partial, "w", version=2) as file:
        _annotate(file, title=experiment.title, Conventions="CF-1.8")
        sizes = {"sweep": len(wanted), "sensor": len(frf.channels), "frequency": len(frf.frequency)}
        for name, size in (sizes | {"letter": letters}).items():
            file.createDimension(name, size)
        for name, (values, unit) in ({"frequency": (frf.frequency, "Hz")} | of_sweeps | fields).items():
            axes = ("frequency",) if name == "frequency" else ("sweep",) if name in of_sweeps else tuple(sizes)
            made = file.createVariable(name, "d", axes)
            made[:] = values
            _annotate(made, units=unit, **({"coordinates": " ".join(of_sweeps)} if name in fields else {}))
        named = np.array([name.encode().ljust(letters) for name in frf.channels], dtype=f"S{letters}")
        file.createVariable("sensor_name", "c", ("sensor", "letter"))[:] = named.view("S1").reshape(-1, letters)


def _annotate(holder: Any, **attributes: str) -> None:
    """Set attributes of a netCDF file or of a variable in it."""
    for name, value in attributes.items():
        setattr(holder, name, value)


def _word(name: str) -> str:
    """Return a name as MATLAB allows it in a variable's."""
    return re.sub(r"\W", "_", name, flags=re.ASCII)


def _write_csv(target: Path, experiment: Experiment, frf: Frf, wanted: list[int], *, alone: bool) -> list[Path]:
    """Write a table for each sweep: frequency, and real part, imaginary part and coherence of every sensor."""
    made = []
    for sweep in wanted:
        output = [f"{one.id}" for one in experiment.outputs]
        units = [frf.unit(row, sweep) for row in range(len(output))]
        coherence = stated_coherence(frf, sweep)
        columns: dict[str, Real] = {"frequency [Hz]": frf.frequency}
        for row, (name, unit) in enumerate(zip(output, units, strict=True)):
            columns |= {
                f"{name} real [{unit}]": frf.h[sweep, row].real,
                f"{name} imag [{unit}]": frf.h[sweep, row].imag,
            }
        for row, name in enumerate(output):
            columns[f"{name} coherence"] = coherence[row]
        path = target if alone else target.with_name(f"{target.stem}_{_named(frf, sweep)}.csv")
        while path in made:  # two sweeps at one temperature
            path = path.with_name(f"{path.stem}_again.csv")
        write_text(path, _table(columns))
        made.append(path)
    return made


def _named(frf: Frf, sweep: int) -> str:
    """Return what names a sweep in a file's name: ``20.01C_up_0.3V``."""
    where = f"_{frf.drives[sweep]}" if frf.sources else ""
    level = f"{frf.level[sweep]:g}{frf.level_unit(sweep)}"
    return f"{frf.temperature[sweep]:.2f}C_{frf.direction[sweep]}_{level}{where}"


def _table(columns: Mapping[str, Real]) -> str:
    rows = np.array([*columns.values()]).T
    text = [",".join(columns)]
    text += [",".join(f"{value:.15g}" for value in row) for row in rows]
    return "\n".join(text) + "\n"
