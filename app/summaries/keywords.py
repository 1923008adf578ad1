"""Messages and notes as the library says them: its keywords in place of the options of the verbs.

Stages serve both and name options, ``--weather``. What filters are made of is a setting of the panel.
"""

import re
from collections.abc import Collection, Mapping

OTHERWISE: Mapping[str, str] = {"from": "first", "until": "last", "set": "options"}
"""Keywords that are not called like their option: ``from`` is a word of Python's own."""
OF_PANELS = frozenset(
    {
        "aim",
        "zone",
        "design",
        "taps",
        "sample_rate",
        "delay",
        "outside_weight",
        "thermometer_error",
        "level",
    }
)
"""Options of the verbs that are keys of ``[filters]`` of a panel's file."""
COMMAND = r"\b(?:flexura|start\.py|pip install) .*?(?=[;)\n]|[,.]\s|$)"
"""To be typed in a shell, as far as the next pause of the sentence."""
OPTION = r"(?<![\w-])--(?P<option>[a-z][a-z-]*)"
VALUE = r"(?: (?P<value>field|volume|listeners|inverse-fft|[\d.]+)\b)?"
"""What a setting of filters is to become, where the message says."""


def in_keywords(message: str, keywords: Collection[str] | None = None) -> str:
    """Return a message with keywords in place of options.

    Commands in it keep their options.

    Parameters
    ----------
    keywords : collection of str, optional
        Of the function that says it; options that it does not have stay. All are replaced where it is left out, as
        in notes of a result, which do not know what computed it.
    """

    def said(found: re.Match[str]) -> str:
        option = found["option"]
        if option is None:
            return found[0]
        keyword, value = OTHERWISE.get(option, option.replace("-", "_")), found["value"]
        known = keyword not in OF_PANELS if keywords is None else keyword in keywords
        if known:
            return keyword if value is None else f"{keyword} {value}"
        if keyword not in OF_PANELS:
            return found[0]
        return f"{keyword}{'' if value is None else f' = {value}'} of [filters] of the panel"

    return re.sub(f"{COMMAND}|{OPTION}{VALUE}", said, message)
