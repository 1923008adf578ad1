"""Single keys of a terminal, taken without waiting for them."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from drivers.hammer.campaign import Key, no_key

MEANING: dict[str, Key] = {"u": "undo", "s": "skip", "r": "repeat", "q": "stop"}


@contextmanager
def hammer_keys() -> Iterator[Callable[[], Key | None]]:
    """Yield what returns a key typed since it was called last, None where none was, or nobody can type.

    On a terminal, what is typed is neither shown nor held back until the end of a line; the terminal is as it was
    when the block ends. Ctrl-C stays what it is. A terminal that has gone, or that belongs to another program now,
    gives no key.
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
    try:
        before = termios.tcgetattr(number)
        tty.setcbreak(number)
    except termios.error:
        yield no_key
        return

    def typed() -> Key | None:
        try:
            if not select.select([number], [], [], 0.0)[0]:
                return None
            return MEANING.get(os.read(number, 1).decode(errors="replace").lower())
        except (
            OSError
        ):  # EIO: a closed terminal must not end a test, nor must one of which this is in the background
            return None

    try:
        yield typed
    finally:
        with suppress(termios.error):
            termios.tcsetattr(number, termios.TCSADRAIN, before)
