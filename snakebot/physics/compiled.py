"""How kernels are compiled: to machine code, once, kept on disk beside the source.

numba keeps compiled code as long as the file of the *calling* function is unchanged, though code of functions in other
files is built into it. So code that is older than a source built into it is thrown away here, before it can be loaded.
"""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numba import njit
from numba.core import event

_HERE = Path(__file__).resolve().parent

# Sources that are built into others, and whose compiled code they are built into.
_BUILT_INTO = (
    (("compiled", "lanes", "elementary", "kernel", "rosenbrock", "imposed"), "*.nbi"),
    (("servo", "servo_chain", "servo_first_order", "servo_layout", "servo_grip", "servo_loop"), "servo*.nbi"),
)


def drop_stale_caches() -> None:
    """Delete cached code that is older than a source it holds."""
    for sources, pattern in _BUILT_INTO:
        with contextlib.suppress(OSError):  # read-only install, or another process was first
            newest = max((_HERE / f"{source}.py").stat().st_mtime for source in sources)
            for index in (_HERE / "__pycache__").glob(pattern):
                if index.stat().st_mtime < newest:
                    index.unlink()


drop_stale_caches()

# These let the compiler fuse and simplify; none of them lets results differ from run to run, and NaN stays NaN.
FAST = {"contract", "nsz", "arcp"}

jit = njit(cache=True, nogil=True, fastmath=FAST, error_model="numpy")

# The same for what makes no array of its own: it does not count who holds the arrays that it is given. numba counts
# each slice of an array that goes from function to function, by an atomic instruction; of a chain that follows its
# servos that took three fifths of the time. What makes an array even so does not compile.
# Sums in any order: several of their terms are added at once.
if TYPE_CHECKING:
    in_place = in_place_in_any_order = jit  # the option is one that numba's types leave out
else:
    in_place = njit(cache=True, nogil=True, fastmath=FAST, error_model="numpy", _nrt=False)
    in_place_in_any_order = njit(
        cache=True, nogil=True, fastmath=FAST | {"reassoc"}, error_model="numpy", _nrt=False
    )


class _Compiling(event.Listener):
    """Notes that a kernel is being compiled; one that is loaded from disk is not."""

    begun = 0
    ended = 0

    def on_start(self, event: Any) -> None:
        self.begun += 1

    def on_end(self, event: Any) -> None:
        self.ended += 1


_compiling = _Compiling()
event.register("numba:compile", _compiling)  # type: ignore[no-untyped-call]


def compiles() -> bool:
    """Whether a kernel is being compiled now, in whichever thread."""
    return _compiling.begun > _compiling.ended
