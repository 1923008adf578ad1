"""Volts at the cards and units of the plate: the one place where the ones become the others."""

from dataclasses import dataclass, replace

import numpy as np

from analysis.campaign import Sweep
from analysis.channel import Channel


@dataclass(frozen=True)
class Sensitivity:
    """What a channel's transducer, its conditioner included, gives at the card.

    Attributes
    ----------
    channel : Channel
    volts : float
        V per unit of the channel; 1 for one that is read in volts.
    """

    channel: Channel
    volts: float = 1.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.volts) and self.volts > 0.0):
            raise ValueError(f"channel {self.channel.id!r}: {self.volts:g} V/{self.channel.unit}; above 0 allowed")
        if self.channel.unit == "V" and self.volts != 1.0:
            raise ValueError(f"channel {self.channel.id!r} is read in volts, {self.volts:g} V/V; 1 allowed")


@dataclass(frozen=True)
class Sensitivities:
    """Those of all channels of a campaign.

    Attributes
    ----------
    drive : Sensitivity
        Of what is recorded of the input: the generator's volts (1 V/V), or the force sensor.
    responses : (K,) tuple of Sensitivity
    """

    drive: Sensitivity
    responses: tuple[Sensitivity, ...]

    @property
    def units(self) -> tuple[str, ...]:
        """Of the drive, then of each response."""
        return tuple(one.channel.unit for one in (self.drive, *self.responses))

    def measured(self, sweep: Sweep) -> Sweep:
        """Return a sweep recorded in volts in the units of its channels; volts stay what they are, bit by bit."""
        if len(sweep.responses) != len(self.responses):
            raise ValueError(f"{len(sweep.responses)} responses; {len(self.responses)} sensitivities are declared")
        volts = np.array([one.volts for one in self.responses], dtype=sweep.responses.dtype)
        return replace(
            sweep,
            drive=sweep.drive / sweep.drive.dtype.type(self.drive.volts),
            responses=sweep.responses / volts[:, None, None],
        )
