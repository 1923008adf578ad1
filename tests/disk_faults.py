"""Faults of the disk in a process of its own: a small C library, compiled here, stands before the system's calls.

The process names the call that fails, counted over all calls on files whose path contains a word, through
`ctypes`: ``arm(word, number, error)``. From that call on all fail, as those of a full disk do; an `error` of -1
lets them wait until ``arm`` is called again, as a network share does that has gone.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SOURCE = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

static char word[256] = "\1";
static volatile long count, first;
static volatile int error;
static __thread int looking;

void arm(const char *path, long number, int wanted)
{
    strncpy(word, path, sizeof word - 1);
    count = 0;
    first = number;
    error = wanted;
}

long counted(void) { return count; }

static int refused(const char *path)
{
    if (looking || !path || !strstr(path, word))
        return 0;
    long mine = __sync_add_and_fetch(&count, 1);
    if (!first || mine < first)
        return 0;
    while (error == -1) {
        struct timespec a_while = {0, 10000000};
        nanosleep(&a_while, NULL);
    }
    return error;
}

static int refused_file(int file)
{
    char link[64], path[1024];
    looking = 1;
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, sizeof path - 1);
    looking = 0;
    if (length < 0)
        return 0;
    path[length] = 0;
    return refused(path);
}

#define REAL(type, name, ...) \
    static type (*real)(__VA_ARGS__); \
    if (!real) \
        real = dlsym(RTLD_NEXT, name)
#define UNLESS(found) \
    int why = found; \
    if (why) { \
        errno = why; \
        return -1; \
    }

#define OPEN(name) \
    int name(const char *path, int flags, ...) \
    { \
        REAL(int, #name, const char *, int, ...); \
        va_list more; \
        va_start(more, flags); \
        int mode = va_arg(more, int); \
        va_end(more); \
        UNLESS(flags & O_CREAT ? refused(path) : 0) \
        return real(path, flags, mode); \
    }
OPEN(open)
OPEN(open64)
ssize_t write(int file, const void *data, size_t size)
{
    REAL(ssize_t, "write", int, const void *, size_t);
    UNLESS(refused_file(file))
    return real(file, data, size);
}
#define PWRITE(name, offset) \
    ssize_t name(int file, const void *data, size_t size, offset at) \
    { \
        REAL(ssize_t, #name, int, const void *, size_t, offset); \
        UNLESS(refused_file(file)) \
        return real(file, data, size, at); \
    }
PWRITE(pwrite, off_t)
PWRITE(pwrite64, off64_t)
int fsync(int file)
{
    REAL(int, "fsync", int);
    UNLESS(refused_file(file))
    return real(file);
}
int ftruncate(int file, off_t size)
{
    REAL(int, "ftruncate", int, off_t);
    UNLESS(refused_file(file))
    return real(file, size);
}
int ftruncate64(int file, off64_t size)
{
    REAL(int, "ftruncate64", int, off64_t);
    UNLESS(refused_file(file))
    return real(file, size);
}
int rename(const char *from, const char *to)
{
    REAL(int, "rename", const char *, const char *);
    UNLESS(refused(from))
    return real(from, to);
}
"""

PREAMBLE = """
import ctypes, errno, os, sys
disk = ctypes.CDLL(os.environ["LD_PRELOAD"])
def arm(word, number, error):
    disk.arm(os.fsencode(word), ctypes.c_long(number), error)
"""

GCC = shutil.which("gcc") or ""
needs_compiler = pytest.mark.skipif(
    sys.platform != "linux" or not GCC, reason="needs gcc and Linux's preloaded libraries"
)


def preloaded(folder: Path) -> dict[str, str]:
    """Compile the library into a folder, once, and return the environment of a process that has it."""
    library = folder / "disk_faults.so"
    if not library.exists():
        source = folder / "disk_faults.c"
        source.write_text(SOURCE, encoding="ascii")
        subprocess.run([GCC, "-shared", "-fPIC", "-o", library, source, "-ldl"], check=True)
    root = str(Path(__file__).resolve().parents[1])
    return os.environ | {"LD_PRELOAD": str(library), "PYTHONPATH": root}


def with_faults(
    folder: Path, code: str, *words: object, seconds: float = 300.0
) -> subprocess.CompletedProcess[str]:
    """Run Python code that may call ``arm``, with `words` as its arguments, and return how it ended.

    Parameters
    ----------
    folder : Path
        The library is compiled into it, once.
    code : str
    *words : object
    seconds : float
        After which it is taken to hang.
    """
    return subprocess.run(
        [sys.executable, "-c", PREAMBLE + code, *map(str, words)],
        env=preloaded(folder),
        capture_output=True,
        text=True,
        timeout=seconds,
        check=False,
    )
