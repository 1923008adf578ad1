"""Mutations read one after the other in a process of its own, with a bound on its memory."""

import os
import traceback
import warnings
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError
from tests.fuzz.fingerprint import fingerprint
from tests.fuzz.mutations import mutated
from tests.fuzz.reader import Reader
from tests.fuzz.readers import READERS

MEMORY = 1_000_000_000
"""Bytes that reading any one file may take."""
Whole = dict[str, tuple[bytes, str]]
REFUSALS = (CampaignFileError, ResultFileError)
"""What verbs turn into a sentence and exit status 2."""


def read_mutations(pipe: Connection, root: Path, place: int, seed: int, first: int, end: int) -> None:
    """Read mutations `first` to `end` of one reader's files, telling of each before and after.

    Before: its number. After: what came of it, what was said, and the most memory this process ever held, bytes.
    """
    import resource

    warnings.simplefilter("ignore")
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    whole = whole_files(READERS[place], root)
    _bound_memory()
    pipe.send("ready")
    for number in range(first, end):
        pipe.send(number)
        came, said = read_mutation(place, root, whole, seed, number)
        pipe.send((came, said, 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss))
    pipe.close()


def whole_files(reader: Reader, root: Path) -> Whole:
    """Bytes of the files of a reader before they are damaged, and a digest of what is read from them."""
    known = {name: fingerprint(reader.read(root, name)) for name in reader.files}
    return {name: ((root / name).read_bytes(), known[name]) for name in reader.files}


def read_mutation(place: int, root: Path, whole: Whole, seed: int, number: int) -> tuple[str, str]:
    """Damage a file, read it, and put it right again.

    Returns
    -------
    str
        ``read``, ``refused``, ``traceback``, ``memory``, or ``silent`` where a file with a digest gives
        other values.
    str
        What was said.
    """
    reader = READERS[place]
    name = reader.files[number % len(reader.files)]
    content, _ = whole[name]
    rng = np.random.default_rng([seed, place, number])
    damaged = reader.damage(content, rng) if reader.damage else mutated(content, rng, reader.text)
    return read_damaged(reader, root, whole, name, damaged)


def read_damaged(reader: Reader, root: Path, whole: Whole, name: str, damaged: bytes) -> tuple[str, str]:
    """Read a damaged file, and put it right again; what came of it, as `read_mutation`."""
    content, known = whole[name]
    (root / name).write_bytes(damaged)
    try:
        found = reader.read(root, name)
    except REFUSALS as refusal:
        return "memory" if _out_of_memory(refusal) else "refused", str(refusal)
    except MemoryError:
        return "memory", traceback.format_exc()
    except Exception:  # noqa: BLE001 (that there is none is what is tested)
        return "traceback", traceback.format_exc()
    finally:
        (root / name).write_bytes(content)
    if found is None:
        return "refused", ""
    return "silent" if reader.digest and fingerprint(found) != known else "read", ""


def _out_of_memory(refusal: BaseException | None) -> bool:
    while refusal is not None:
        if isinstance(refusal, MemoryError):
            return True
        refusal = refusal.__cause__ or refusal.__context__
    return False


def _bound_memory() -> None:
    """Let this process take no more address space than it has and `MEMORY`, where the system tells."""
    import resource

    if not Path("/proc/self/statm").exists():
        return
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    most = pages * resource.getpagesize() + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
