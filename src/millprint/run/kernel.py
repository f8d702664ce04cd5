"""Compilation of the numerical kernels: without Python objects, with one thread by default, cached on disk.

Numba keys its cache by the date of a function's file, and does not see edits of the functions that it calls. So the
name of the cache folder depends on the contents of every kernel file: an edit starts a new cache. It also depends on
the type of the processor, because the nodes of a cluster may share the folder.
"""

import hashlib
import os
import re
import shutil
from functools import partial
from pathlib import Path
from typing import Any

import numba
from llvmlite import binding

from millprint.run import digest
from millprint.run.machine import CACHE_ROOT

PACKAGE = Path(__file__).parents[1]
KERNEL_FOLDERS = ("mill", "dem", "thesis/surrogate")
MAKERS = re.compile(r"from millprint\.run\.kernel import .*\b(kernel|inner|inlined|threaded|array_maker|merged)\b")


def processor_type() -> str:
    """Name of the processor and a short hash of its instruction sets, on which machine code depends."""
    features = binding.get_host_cpu_features().flatten()
    return f"{binding.get_host_cpu_name()}-{hashlib.sha256(features.encode()).hexdigest()[:6]}"


def kernel_files() -> list[Path]:
    """Every library file with kernels, and the files that these import, whose constants are compiled in.

    Settings (millprint.config) reach kernels as arguments, and are left out, as is millprint.run.digest.
    """
    kernels = [file for folder in KERNEL_FOLDERS for file in (PACKAGE / folder).glob("*.py")]
    found: set[str] = set()
    waiting = {"run/kernel.py"}
    waiting |= {str(file.relative_to(PACKAGE)) for file in kernels if MAKERS.search(file.read_text())}
    while waiting := {name for name in waiting - found if not name.startswith(("config/", "run/digest"))}:
        found |= waiting
        waiting = {name for each in waiting for name in digest.imports(PACKAGE / each, digest.AT_ONCE)}
    return sorted(PACKAGE / name for name in found)


def kernel_digest() -> str:
    """A short hash of what the kernels compute, without comments, and of the compiler's version."""
    total = hashlib.sha256(numba.__version__.encode())
    for file in kernel_files():
        total.update(file.name.encode())
        total.update(digest.content_digest(file))
    return total.hexdigest()[:16]


def cache_folder() -> Path:
    """The folder of this version's machine code for this type of processor."""
    return CACHE_ROOT / f"{kernel_digest()}-{processor_type()}"


def drop_old_caches() -> None:
    """Remove the machine code of earlier versions of the kernels for this type of processor."""
    for folder in CACHE_ROOT.glob("*"):
        of_another = "-" in folder.name and not folder.name.endswith(f"-{processor_type()}")
        if folder.is_dir() and folder != cache_folder() and not of_another:
            shutil.rmtree(folder, ignore_errors=True)


if "NUMBA_CACHE_DIR" not in os.environ:
    numba.config.CACHE_DIR = str(cache_folder())

# Without nnan and ninf, so that a lost ball shows up as NaN. Division by zero follows IEEE. The wrappers for calls from
# C are not needed, and compiling them would take a fifth of the time.
_OPTIONS = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract", "nsz", "arcp"},
    "no_cfunc_wrapper": True,
}

# Kernels make no arrays, so they need no reference counts: counting costs thirty times the physics.
kernel = partial(numba.njit, _nrt=False, **_OPTIONS)
# For functions that only kernels call. They have no wrapper for Python either: in a small function, both wrappers take
# as long to compile as the rest. Python must not call these functions: the process would end silently.
inner = partial(numba.njit, _nrt=False, no_cpython_wrapper=True, **_OPTIONS)
inlined = partial(inner, forceinline=True)
# The same for a function that is chosen by the types of its arguments (numba.extending.overload).
INLINED: Any = {name: value for name, value in inlined.keywords.items() if name != "cache"}
# For a part of one kernel, such as the gathering of contacts: its statements become those of its caller, and it is not
# compiled by itself. A function that many call is better compiled once.
merged = partial(inner, inline="always")

# For loops over `prange` whose body is the call of one kernel. They count references, once per call.
threaded = partial(numba.njit, parallel=True, **_OPTIONS)

# For the few functions that make arrays, outside of the time steps.
array_maker = partial(numba.njit, **_OPTIONS)
