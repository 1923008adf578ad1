"""Error that refuses networks, in a module of its own so that catching it does not import torch."""


class EvidenceCollapseError(RuntimeError):
    """No network of some actuator is accurate enough; the message names the actuator and what to try."""
