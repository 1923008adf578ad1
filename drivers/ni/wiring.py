"""Which terminal of which card is connected to what: inputs of a rig, with an output or without."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from analysis.declaration.strict import Sparse
from drivers.ni.cards import Cards, CardsSettings

Terminal = Annotated[
    str, Field(pattern=r"^[^/\s,:]+/[a-z]+[0-9]+$", description="as NI MAX shows it: cDAQ1Mod1/ai0")
]


class InputWiring(CardsSettings):
    """The inputs' connections and settings, as written in an experiment's file.

    Attributes
    ----------
    kind : str
    drive_input : str
        Analog input that records the drive, on the same kind of module as the responses: only then
        do the modules' filter delays cancel in a ratio.
    responses : (K,) tuple of str
        Analog inputs of the sensors, in the experiment's order.
    thermocouples : tuple of str
        Inputs of a thermocouple module.
    thermocouple_type : str
    sample_rate : float
        Asked for, Hz; what the hardware makes of it is read back.
    input_range : float
        Largest magnitude expected, V.
    terminal_configuration : str
        How the inputs are wired; DEFAULT is the device's own, the only one that a C Series module has.
    coupling : str
        DC for a piezo patch; AC has lost 3 dB near 0.5 Hz; DEFAULT for a device that has no choice.
    iepe : tuple of str
        Those of the inputs that feed IEPE sensors: accelerometers, force sensors, microphones. They couple AC.
    iepe_settling : float
        How long every sweep is preceded by silence in which the sensors' bias settles, s; not recorded.
    grpc : str, optional
        ``host:port`` of an NI gRPC Device Server; the local driver if left out.
    """

    kind: Literal["ni"] = "ni"
    drive_input: Terminal
    responses: Annotated[tuple[Terminal, ...], Field(min_length=1)]
    thermocouples: tuple[Terminal, ...] = ()
    thermocouple_type: Literal["B", "E", "J", "K", "N", "R", "S", "T"] = "K"
    terminal_configuration: Literal["DEFAULT", "PSEUDO_DIFF", "DIFF", "RSE", "NRSE"] = "DEFAULT"
    coupling: Literal["DC", "AC", "DEFAULT"] = "DC"
    iepe: tuple[Terminal, ...] = ()
    iepe_settling: Annotated[float, Field(ge=0.0, le=60.0, description="s of silence before every sweep")] = 5.0
    grpc: Annotated[str, Field(pattern=r"^.+:[0-9]{1,5}$", description="host:port")] | None = None

    @property
    def inputs(self) -> tuple[str, ...]:
        """The drive's input, then the responses'."""
        return (self.drive_input, *self.responses)

    @property
    def has_thermocouples(self) -> bool:
        """Whether any is wired."""
        return bool(self.thermocouples)

    @property
    def settling(self) -> float:
        """Silence before every sweep, s."""
        return self.iepe_settling if self.iepe else 0.0

    @property
    def terminals(self) -> tuple[str, ...]:
        """All that is wired."""
        return (*self.inputs, *self.thermocouples)

    @property
    def places(self) -> tuple[str, ...]:
        """Chassis or boards, with the server they are on."""
        devices = [terminal.split("/")[0] for terminal in self.terminals]
        where = f" at {self.grpc.lower()}" if self.grpc else ""
        return tuple(sorted({f"{device.partition('Mod')[0] or device}{where}" for device in devices}))

    @model_validator(mode="after")
    def _each_terminal_once(self) -> Self:
        terminals = self.terminals
        for terminal in terminals:
            if terminals.count(terminal) > 1:
                raise ValueError(f"terminal {terminal!r} is used {terminals.count(terminal)} times")
        for terminal in (*self.inputs, *self.thermocouples):
            require_kind("ai", terminal)
        return self

    @model_validator(mode="after")
    def _fed_inputs_are_inputs(self) -> Self:
        for terminal in self.iepe:
            if terminal not in self.inputs:
                raise ValueError(f"iepe names {terminal!r}, which is none of the inputs {', '.join(self.inputs)}")
        others = [terminal for terminal in self.inputs if terminal not in self.iepe]
        if self.iepe and others and self.coupling != "AC":
            raise ValueError(
                f"inputs with iepe couple AC, {others[0]!r} would couple {self.coupling}: their ratio is off "
                'by 5 mrad at 100 Hz; set coupling = "AC"'
            )
        return self

    def _left_out(self) -> set[str]:
        return super()._left_out() | (Sparse._left_out(self) & {"iepe", "iepe_settling"})


def require_kind(kind: str, terminal: str) -> None:
    """Raise ValueError for a terminal that is no ``ai`` or no ``ao``, whichever is wanted."""
    if not terminal.rsplit("/", 1)[1].startswith(kind):
        raise ValueError(f"terminal {terminal!r} is not of the kind {kind}0, {kind}1, … wanted there")


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
