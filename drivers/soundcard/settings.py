"""``[cards] kind = "soundcard"``: which channels, and what their full scale is worth."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from drivers.ni.cards import Cards, CardsSettings, Volts

Input = Annotated[str, Field(pattern=r"^in[1-9][0-9]?$", description="in1, in2, …")]
Output = Annotated[str, Field(pattern=r"^out[1-9][0-9]?$", description="out1, out2, …")]


class SoundCard(CardsSettings):
    """Channels of a sound card.

    Attributes
    ----------
    kind : str
    device : str
        Name of the device, or a part of it; the system's own choice if left out.
    output : str
        Drives the amplifier, and by a loop-back cable `drive_input`.
    drive_input : str
        Records the drive.
    responses : (K,) tuple of str
        Of the sensors, in the experiment's order.
    input_range, output_range : float
        Voltage of a sample of 1, V: what the volume controls are set to.
    """

    kind: Literal["soundcard"] = "soundcard"
    device: str = ""
    output: Output
    drive_input: Input
    responses: Annotated[tuple[Input, ...], Field(min_length=1)]
    sample_rate: Annotated[float, Field(ge=8_000.0, le=384_000.0, description="Hz")] = 48_000.0
    input_range: Volts
    output_range: Volts

    @property
    def inputs(self) -> tuple[str, ...]:
        """The drive's input, then the responses'."""
        return (self.drive_input, *self.responses)

    def open(self) -> Cards:
        """Open it through ``sounddevice``."""
        from drivers.soundcard.card import SoundCards  # which imports this class

        return SoundCards(self)

    @model_validator(mode="after")
    def _each_input_once(self) -> Self:
        for name in self.inputs:
            if self.inputs.count(name) > 1:
                raise ValueError(f"input {name!r} is used {self.inputs.count(name)} times")
        return self


def channel_number(name: str) -> int:
    """Return the number in a channel's name, from 1."""
    return int(name.removeprefix("out").removeprefix("in"))
