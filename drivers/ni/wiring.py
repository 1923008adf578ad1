"""Which terminal of which card is connected to what: the part of an experiment that is the rig."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from drivers.ni.cards import Cards, CardsSettings

Terminal = Annotated[
    str, Field(pattern=r"^[^/\s,:]+/[a-z]+[0-9]+$", description="as NI MAX shows it: cDAQ1Mod1/ai0")
]


class Wiring(CardsSettings):
    """The cards' connections and settings, as written in an experiment's file.

    Attributes
    ----------
    kind : str
    output : str
        Analog output that drives the amplifier.
    drive_input : str
        Analog input that records the drive, on the same kind of module as the responses: only then
        do the modules' filter delays cancel in a ratio.
    responses : (K,) tuple of str
        Analog inputs of the sensor patches, in the experiment's order.
    thermocouples : tuple of str
        Inputs of a thermocouple module.
    thermocouple_type : str
    sample_rate : float
        Asked for, Hz; what the hardware makes of it is read back.
    input_range, output_range : float
        Largest magnitude expected, V.
    terminal_configuration : str
        How the inputs are wired; DEFAULT is the device's own, the only one that a C Series module has.
    coupling : str
        DC for a piezo patch; AC has lost 3 dB near 0.5 Hz; DEFAULT for a device that has no choice.
    grpc : str, optional
        ``host:port`` of an NI gRPC Device Server; the local driver if left out.
    """

    kind: Literal["ni"] = "ni"
    output: Terminal
    drive_input: Terminal
    responses: Annotated[tuple[Terminal, ...], Field(min_length=1)]
    thermocouples: tuple[Terminal, ...] = ()
    thermocouple_type: Literal["B", "E", "J", "K", "N", "R", "S", "T"] = "K"
    terminal_configuration: Literal["DEFAULT", "PSEUDO_DIFF", "DIFF", "RSE", "NRSE"] = "DEFAULT"
    coupling: Literal["DC", "AC", "DEFAULT"] = "DC"
    grpc: Annotated[str, Field(pattern=r"^.+:[0-9]{1,5}$", description="host:port")] | None = None

    @property
    def inputs(self) -> tuple[str, ...]:
        """The drive's input, then the responses'."""
        return (self.drive_input, *self.responses)

    @property
    def has_thermocouples(self) -> bool:
        """Whether any is wired."""
        return bool(self.thermocouples)

    def open(self) -> Cards:
        """Open them through NI-DAQmx."""
        from drivers.ni.daqmx import DaqmxCards  # which knows this class, and loads the vendor's package

        return DaqmxCards(self)

    @model_validator(mode="after")
    def _each_terminal_once(self) -> Self:
        terminals = (self.output, *self.inputs, *self.thermocouples)
        for terminal in terminals:
            if terminals.count(terminal) > 1:
                raise ValueError(f"terminal {terminal!r} is used {terminals.count(terminal)} times")
        for kind, named in (("ao", (self.output,)), ("ai", self.inputs + self.thermocouples)):
            for terminal in named:
                if not terminal.rsplit("/", 1)[1].startswith(kind):
                    raise ValueError(f"terminal {terminal!r} is not of the kind {kind}0, {kind}1, … wanted there")
        return self
