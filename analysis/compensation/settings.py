"""Settings of the training of networks."""

from dataclasses import dataclass, replace

FEWEST_TRAINING_TEMPERATURES = 4
"""Fewest training temperatures: one is left out to find the error, and a curve needs three."""

SPACINGS = (0.5, 30.0)
"""K between training temperatures."""
PLACES = (4, 40)
"""Training temperatures that are placed by need."""
ACROSS = (0.1, 60.0)
"""K between two sides of a panel, at which filters are tried."""


@dataclass(frozen=True)
class Training:
    """Settings of a training.

    Attributes
    ----------
    nodes : int
        Hidden tanh nodes.
    feed : str
        ``rigidity``: log √D(T) of the panel's plate, with which its modes' log frequencies change linearly, so
        that ripples of a measured law do no harm; ``temperature``: the temperature itself, as in the paper.
    scale : str
        ``global``: one scale for all taps of an actuator, so that errors count as in eq. (13);
        ``tap``: every tap stretched to -1..1, as MATLAB does it.
    start : str
        ``warm``: output layer from a ridge fit; ``random``: as MATLAB does it.
    split : str
        ``none``: train on all temperatures; ``matlab``: leave 15 % out at random, another share for every
        network, as the paper's toolbox does.
    restarts : int
        Trainings per actuator; the one of highest evidence is kept.
    epochs : int
        Most steps of a training.
    largest_error : float
        Relative error at the training temperatures, %, above which a network is refused: the evidence has then
        collapsed, and the network explains the filters as noise.
    seed : int
    """

    nodes: int = 10
    feed: str = "rigidity"
    scale: str = "global"
    start: str = "warm"
    split: str = "none"
    restarts: int = 1
    epochs: int = 1000
    largest_error: float = 1.0
    seed: int = 0

    def __post_init__(self) -> None:
        for name, low, high in (("nodes", 1, 100), ("restarts", 1, 1000), ("epochs", 1, 1_000_000)):
            if type(getattr(self, name)) is not int:
                raise TypeError(f"{name} {getattr(self, name)!r}: an integer is wanted")
            if not low <= getattr(self, name) <= high:
                raise ValueError(f"{name} {getattr(self, name)} is outside {low} to {high}")
        for name, choices in (
            ("feed", ("rigidity", "temperature")),
            ("scale", ("global", "tap")),
            ("start", ("warm", "random")),
            ("split", ("none", "matlab")),
        ):
            if getattr(self, name) not in choices:
                raise ValueError(f"{name} {getattr(self, name)!r}: {' or '.join(choices)}")
        if type(self.seed) is not int or self.seed < 0:
            raise ValueError(f"seed {self.seed!r}: an integer from 0 on is wanted")
        if not isinstance(self.largest_error, int | float):
            raise TypeError(f"largest_error {self.largest_error!r}: a number is wanted")
        if not 0.0 < self.largest_error <= 100.0:
            raise ValueError(f"largest_error {self.largest_error:g} % is outside 0 to 100 %")

    def check_temperatures(self, count: int) -> None:
        """Raise ValueError where `count` training temperatures are too few to distinguish a curve from noise.

        Networks may have more nodes than temperatures, as in the paper: the evidence regularises them, and a
        network with large errors at its own training temperatures is refused.
        """
        if count < FEWEST_TRAINING_TEMPERATURES:
            raise ValueError(
                f"{count} training temperatures; at least {FEWEST_TRAINING_TEMPERATURES} are needed: "
                "take a smaller spacing"
            )

    def as_paper(self) -> "Training":
        """Return these settings with the paper's feed, scale, start and split."""
        return replace(self, feed="temperature", scale="tap", start="random", split="matlab")


def suited_nodes(temperatures: int, *, measured: bool = False) -> int:
    """Return the number of hidden nodes: as many as few temperatures can determine, the usual number for many.

    Two fewer than the temperatures. Where filters were measured, each is left out in turn: then five fewer, and
    at least three. At 13 temperatures of a panel known in closed form, networks of 6 and 8 nodes lost 0.006 of
    contrast where they were left out, networks of 10 lost 0.08.
    """
    least, fewer = (3, 5) if measured else (1, 2)
    return max(least, min(Training.nodes, temperatures - fewer))
