"""Responses of a campaign that still ring where their record ends."""

from analysis.campaign import Campaign
from analysis.estimation.ringing import ringing


def still_ringing(campaign: Campaign) -> str:
    """Say which response rings most where its record ends; empty where all are at rest."""
    tail, rate = campaign.experiment.protocol.tail, campaign.experiment.acquisition.sample_rate
    names = [output.id for output in campaign.experiment.outputs]
    seen = [
        (found, sweep, name)
        for sweep in campaign.sweeps
        for name, response in zip(names, sweep.responses, strict=True)
        if (found := ringing(response.astype(float), rate, tail)) is not None
    ]
    if not seen:
        return ""
    worst, sweep, name = max(seen, key=lambda one: one[0].share)
    where = f"{name} at {sweep.temperature:.1f} °C ({len(seen)} of {len(campaign.sweeps) * len(names)} responses)"
    return f"{where} {worst.message(tail, 'lengthen protocol.tail')}"
