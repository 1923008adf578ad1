"""Single keys of a terminal, taken without waiting for them."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from drivers.hammer.campaign import Key, no_key

MEANING: dict[str, Key] = {"u": "undo", "s": "skip", "r": "repeat", "q": "stop"}


@contextmanager
def hammer_keys() -> Iterator[Callable[[], Key | None]]:
    """Yield what returns a key typed since it was called last, None where none was, or nobody can type.

    On a terminal, what is typed is neither shown nor held back until the end of a line; the terminal is as it was
    when the block ends. Ctrl-C stays what it is.
    """
    if not sys.stdin or not sys.stdin.isatty():
        yield no_key
        return
    if sys.platform == "win32":
        import msvcrt

        def pressed() -> Key | None:
            return MEANING.get(msvcrt.getwch().lower()) if msvcrt.kbhit() else None

        yield pressed
        return
    import os
    import select
    import termios
    import tty

    number = sys.stdin.fileno()
    before = termios.tcgetattr(number)

    def typed() -> Key | None:
        if not select.select([number], [], [], 0.0)[0]:
            return None
        return MEANING.get(os.read(number, 1).decode(errors="replace").lower())

    try:
        tty.setcbreak(number)
        yield typed
    finally:
        termios.tcsetattr(number, termios.TCSADRAIN, before)
