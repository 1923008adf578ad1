"""Declared quantities in JSON, alike in ``gap.json`` and in what ``update --json`` prints."""

from typing import Any

from analysis.declared_quantity import DeclaredQuantity


def declared_record(one: DeclaredQuantity) -> dict[str, Any]:
    """Return a declared quantity as JSON holds it: true less declared, in its unit, or a share of the declared."""
    return {
        "name": one.name,
        "parameter": one.parameter,
        "unit": one.unit,
        "tolerance": one.tolerance,
        "value": one.value,
        "sigma": one.sigma,
        "beyond_tolerance": one.beyond,
    }
