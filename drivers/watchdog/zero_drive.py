"""Brings the drive to 0 V: a process of its own, started by the watchdog after the campaign's has died."""

import json
import sys

from drivers.ni.cards import CARDS
from drivers.rig.session import rest_drive


def main() -> int:
    """Read the ``[cards]`` from the standard input; say what could not be verified, and return 3 then."""
    table = json.load(sys.stdin)
    failure = rest_drive(CARDS.find(str(table.get("kind", "ni"))).model_validate(table).open)
    if failure is None:
        return 0
    sys.stdout.write(f"{failure}\n")
    return 3


if __name__ == "__main__":
    sys.exit(main())
