"""Thermocouple modules as their maker describes them: slow, and with a timing of their own."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ThermocoupleModule:
    """A multiplexed thermocouple input module with cold-junction compensation built in.

    Attributes
    ----------
    name : str
        As printed on the module.
    channels : int
    rate : float
        Conversions per second, all channels together, Hz.
    noise : float
        Of one reading with a type K thermocouple, K rms.
    """

    name: str
    channels: int
    rate: float
    noise: float

    def duration(self, channels: int) -> float:
        """Time one reading of so many channels takes, s."""
        return channels / self.rate


NI_9211 = ThermocoupleModule("NI-9211", channels=4, rate=14.0, noise=0.02)
NI_9213 = ThermocoupleModule("NI-9213", channels=16, rate=18.0, noise=0.02)
