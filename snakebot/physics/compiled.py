"""How kernels are compiled: to machine code, once, kept on disk beside the source.

numba keeps compiled code as long as the file of the *calling* function is unchanged, though code of functions in other
files is built into it. So what is older than the newest kernel source is thrown away here, before it can be loaded.
"""

from __future__ import annotations

import contextlib
from pathlib import Path

from numba import njit

_HERE = Path(__file__).resolve().parent
_KERNEL_FOLDERS = (_HERE, _HERE.parent / "effects")


def drop_stale_caches() -> None:
    """Delete cached code that is older than any source it may hold."""
    newest = max((source.stat().st_mtime for source in _HERE.glob("*.py")), default=0.0)
    for folder in _KERNEL_FOLDERS:
        for index in folder.glob("__pycache__/*.nbi"):
            with contextlib.suppress(OSError):  # read-only install, or another process was first
                if index.stat().st_mtime < newest:
                    index.unlink()


drop_stale_caches()

# These let the compiler fuse and simplify; none of them lets results differ from run to run, and NaN stays NaN.
_FAST = {"contract", "nsz", "arcp"}

jit = njit(cache=True, nogil=True, fastmath=_FAST, error_model="numpy")
jit_parallel = njit(cache=True, fastmath=_FAST, error_model="numpy", parallel=True)
