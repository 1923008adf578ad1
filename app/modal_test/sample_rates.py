"""The sample rate of a test's signals: every place that gives it has to agree."""

import re
from dataclasses import replace

from analysis.estimation.quantities import TIMES, axis_scale
from analysis.estimation.sampling import RateSeen, of_step, of_times, settled
from app.files.measurements.columns import Columns
from app.files.modal_test_toml import MEASURED, ModalTest

SAMPLED_RATE = r"(?<![a-z])fs(?![a-z])|sampl\w*[ _]*(rate|freq)|abtast"
"""What a single number of a file is called that can only be the sample rate of its signals."""


def sample_rate(file: str, columns: Columns, test: ModalTest) -> tuple[float, list[str]]:
    """Sample rate of signals: as declared, from their times, or from the file; all that give it have to agree.

    Parameters
    ----------
    file : str
        Its name.

    Returns
    -------
    rate : float
        Hz.
    notes : list of str
        Where the file contradicts the rate that is declared as a number, which is then used.

    Raises
    ------
    ValueError
        Where nothing gives it, times are not evenly spaced, it has too few digits, or two places contradict each
        other; channels that are not used do not count.
    """
    if isinstance(test.sample_rate, float):
        try:
            seen = _rates_of_file(columns, test)
        except ValueError:  # a number that is declared needs no other
            return test.sample_rate, []
        given = RateSeen(test.sample_rate, 0.0, "sample_rate")
        notes = [
            f"{file}: sample_rate = {given.rate:g} Hz is used as declared; {one.place} says {one.rate:.9g} Hz"
            for one in seen
            if not one.agrees(given)
        ]
        return test.sample_rate, notes[:1]
    seen = _rates_of_file(columns, test)
    if isinstance(test.sample_rate, str):
        if test.sample_rate not in columns.scalars:
            held = ", ".join(columns.scalars) or "none"
            raise ValueError(f"sample_rate: no single number {test.sample_rate!r} in the file; it holds: {held}")
        seen.append(RateSeen(columns.scalars[test.sample_rate], 0.0, f"its number {test.sample_rate!r}"))
    if not seen:
        raise ValueError(
            "the files give no sample rate; give sample_rate in Hz, its name in a file, or the role time"
        )
    return settled(seen), []


def _rates_of_file(columns: Columns, test: ModalTest) -> list[RateSeen]:
    """Every rate that a file gives for the channels used; ValueError for a doubtful one."""
    used = [name for name, channel in test.channels.items() if channel.role in MEASURED]
    seen: list[RateSeen] = []
    for name, channel in test.channels.items():
        if channel.role == "time" and name in columns.values:
            written = channel.unit or columns.units.get(name, "s")
            seen.append(
                of_times(columns.values[name].real * axis_scale(written, TIMES, "times"), f"its times {name!r}")
            )
    rates = {name: columns.rates[name] for name in used if name in columns.rates}
    if rates and max(rates.values()) - min(rates.values()) > 1e-6 * max(rates.values()):
        told = ", ".join(f"{name} {rate:.9g} Hz" for name, rate in rates.items())
        raise ValueError(
            f"channels of several rates ({told}); all of a run need one rate: resample them, or give those of "
            "another rate the role unused"
        )
    doubtful = [columns.doubts[name] for name in used if name in columns.doubts]
    if doubtful and not seen:
        raise ValueError(doubtful[0])
    if rates:
        name, rate = next(iter(rates.items()))
        seen.append(
            replace(of_step(1.0 / rate, f"the rate of {name!r}"), place=f"the rate of {name!r} in the file")
        )
    named = [name for name in columns.scalars if re.search(SAMPLED_RATE, name, re.IGNORECASE)]
    if seen and len(named) == 1 and named[0] != test.sample_rate and columns.scalars[named[0]] > 0.0:
        held = RateSeen(columns.scalars[named[0]], 0.0, f"its number {named[0]!r}")
        in_kilohertz = replace(held, rate=1e3 * held.rate)
        seen.append(in_kilohertz if in_kilohertz.agrees(seen[0]) else held)
    return seen
