"""What an experiment may do and will regret."""

from analysis.protocol.protocol import AcquisitionProtocol

STIFFNESS_CHANGE, LOSS_FACTOR = 0.02, 0.05
"""|d ln E / dT| [1/K] and loss factor of a soft polymer: polypropylene between 0 and 60 degrees Celsius."""
WORTH_TELLING = 0.01
"""Change of a resonance within one sweep, as a share of its peak, from which on it is more than usual noise."""


def advice(protocol: AcquisitionProtocol) -> list[str]:
    """Say what is allowed but makes results worse, a sentence each.

    Within a sweep on a ramp the plate goes on changing: at a resonance, dH/H = (dE/E) / eta of what the
    temperature is off its mean.
    """
    rate = protocol.programme.ramp_rate / 60.0
    by_second = 0.5 * rate * STIFFNESS_CHANGE / LOSS_FACTOR
    change = by_second * protocol.sweep.duration
    if change < WORTH_TELLING:
        return []
    return [
        f"sweep.duration = {protocol.sweep.duration:g} s: on a ramp of {protocol.programme.ramp_rate:g} K/min one "
        f"repeat spreads over {rate * protocol.sweep.duration:.2g} K, which changes resonances of a soft polymer "
        f"by {100 * change:.2g} % of their peaks; the twin will miss them by that. "
        f"{WORTH_TELLING / by_second:.2g} s or less, or a slower ramp, keep it below {100 * WORTH_TELLING:g} %"
    ]
