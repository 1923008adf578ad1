"""Advice on a protocol: settings that are allowed, but give worse results."""

STIFFNESS_CHANGE, LOSS_FACTOR = 0.02, 0.05
"""|d ln E / dT| [1/K] and loss factor of a soft polymer: polypropylene between 0 and 60 degrees Celsius."""
LEAST_LINES = 2.0
"""Over the width of a resonance, in the middle of the band."""
LEAST_CHANGE = 0.01
"""Change of a resonance within one sweep, as a share of its peak, from which on it is more than usual noise."""


def unresolved(lines: tuple[float, float], spacing: float, loss_factor: float) -> tuple[str, ...]:
    """Warn where resonances are narrower than the spacing of the lines.

    A record as long as 1/spacing cuts the ringing of such a plate off, too.

    Parameters
    ----------
    lines : (float, float)
        First and last frequency, Hz.
    spacing : float
        Of the lines, Hz.

    Returns
    -------
    tuple of str
        One sentence of advice, or none.
    """
    width = loss_factor * float((lines[0] * lines[1]) ** 0.5)
    if width >= LEAST_LINES * spacing:
        return ()
    return (
        f"lines are {spacing:.2g} Hz apart, resonances of a loss factor of {loss_factor:.2g} about {width:.2g} Hz "
        f"wide: record for {LEAST_LINES / width:.2g} s or longer (sweep.duration, sweep.tail), else the damping "
        "is no better than the lines",
    )


def change_within_sweep(duration: float, ramp_rate: float) -> tuple[str, ...]:
    """Warn how far a plate changes within sweeps of `duration`, s, on a ramp of `ramp_rate`, K/min, if it matters.

    At a resonance, dH/H = (dE/E) / eta of what the temperature is off its mean.
    """
    rate = ramp_rate / 60.0
    by_second = 0.5 * rate * STIFFNESS_CHANGE / LOSS_FACTOR
    change = by_second * duration
    if change < LEAST_CHANGE:
        return ()
    longest = LEAST_CHANGE / by_second
    return (
        f"on a ramp of {ramp_rate:g} K/min a sweep of {duration:g} s spreads over {rate * duration:.2g} K, which "
        f"changes resonances of a soft polymer by {100 * change:.2g} % of their peaks; {longest:.2g} s or less, "
        f"or a slower ramp, keep it below {100 * LEAST_CHANGE:g} %",
    )


def change_over_repeats(record: float, repeats: int, ramp_rate: float, sensitivity: float) -> tuple[str, ...]:
    """Warn where the repeats of a sweep, of which the mean is taken, are at temperatures too far apart.

    To second order, that mean is lower at a resonance by the mean square of (dE/E) / eta over the repeats. Model
    updating takes this into account; what it leaves is about the square of it.

    Parameters
    ----------
    record : float
        Sweep and silence, s.
    repeats : int
        One directly after another.
    ramp_rate : float
        K/min.
    sensitivity : float
        |d ln E / dT| / eta of the plate, 1/K.

    Returns
    -------
    tuple of str
        One sentence of advice, or none.
    """
    apart = record * ramp_rate / 60.0
    change = (sensitivity * apart) ** 2 * (repeats**2 - 1) / 12.0
    if change**2 < LEAST_CHANGE:
        return ()
    shorter = float((LEAST_CHANGE**0.5 / change) ** 0.5)
    spread = apart * (repeats - 1)
    return (
        f"on a ramp of {ramp_rate:g} K/min the {repeats} repeats of a sweep spread over {spread:.2g} K: the "
        f"mean over them lowers resonances by about {100 * change:.2g} %. update and gap take this into account "
        f"to second order only: the loss factor may be wrong by {100 * change**2:.2g} %. A ramp of "
        f"{shorter * ramp_rate:.2g} K/min or slower, or shorter records, keep it below {100 * LEAST_CHANGE:g} %",
    )
