"""Which terminal of which card is connected to what: the part of an experiment that is the rig."""

from typing import Self

from pydantic import model_validator

from drivers.ni.cards import Cards
from drivers.ni.input_wiring import InputWiring, Terminal, require_kind


class Wiring(InputWiring):
    """Connections and settings of the inputs, and of the output that drives.

    Attributes
    ----------
    output : str
        Analog output that drives the amplifier.
    output_range : float
        Largest magnitude expected, V.
    """

    output: Terminal

    @property
    def terminals(self) -> tuple[str, ...]:
        """All that is wired, the output first."""
        return (self.output, *super().terminals)

    def open(self) -> Cards:
        """Open them through NI-DAQmx."""
        from drivers.ni.daqmx import DaqmxCards  # which imports this class, and loads the vendor's package

        return DaqmxCards(self)

    @model_validator(mode="after")
    def _output_is_one(self) -> Self:
        require_kind("ao", self.output)
        return self
