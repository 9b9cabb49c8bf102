"""The scripts of tools/ called in this process, where what they print and answer is tested and no process is."""

from __future__ import annotations

import contextlib
import io
import os
import runpy
import subprocess
import sys
from pathlib import Path
from unittest import mock


def called(script: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """What ``python script words`` prints and its exit status; search path and environment are as before afterwards."""
    line = [str(script), *words]
    out, err = io.StringIO(), io.StringIO()
    with (
        mock.patch.object(sys, "argv", line),
        mock.patch.object(sys, "path", [str(script.parent), *sys.path]),
        mock.patch.dict(os.environ),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            runpy.run_path(str(script), run_name="__main__")
            status = 0
        except SystemExit as ended:
            if isinstance(ended.code, str):
                print(ended.code, file=err)
            status = ended.code if isinstance(ended.code, int) else int(ended.code is not None)
    return subprocess.CompletedProcess(line, status, out.getvalue(), err.getvalue())
