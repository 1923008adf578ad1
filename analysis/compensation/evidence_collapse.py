"""Refusal of networks; told apart from the training, so that who catches it need not import torch."""


class EvidenceCollapseError(RuntimeError):
    """No training of some actuator came out good enough; the message says which and what to try."""
