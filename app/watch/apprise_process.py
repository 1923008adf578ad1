"""Sends one message through Apprise: a process of its own, which the watcher ends if it hangs.

The standard input has one JSON object: ``url``, ``title``, ``body``; without ``title`` the address is only
checked.
"""

import json
import logging
import sys
from importlib import import_module

DELIVERED, FAILED, UNKNOWN, NOT_INSTALLED = 0, 1, 2, 3
"""Exit statuses."""


def main() -> int:
    """Send it, or check the address; return the status. Nothing is printed: Apprise's logs have secrets."""
    logging.disable(logging.CRITICAL)
    try:
        apprise = import_module("apprise")  # of the extra notify
    except ImportError:
        return NOT_INSTALLED
    order = json.load(sys.stdin)
    to = apprise.Apprise()
    if not to.add(order["url"]):
        return UNKNOWN
    if "title" not in order:
        return DELIVERED
    sent = to.notify(title=order["title"], body=order["body"], body_format=apprise.NotifyFormat.TEXT)
    return DELIVERED if sent else FAILED


if __name__ == "__main__":
    sys.exit(main())
