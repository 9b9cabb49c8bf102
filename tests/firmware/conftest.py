"""The firmware built once for all tests, the tools that make its files, and the core with time in the test's hands."""

from __future__ import annotations

import ctypes
import importlib.util
import shutil
import subprocess
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
FIRMWARE = ROOT / "firmware_protocol/firmware"


def need(*programs: str) -> None:
    """Skip, saying so, where a program is missing."""
    for program in programs:
        if shutil.which(program) is None:
            pytest.skip(f"{program} is not installed")


def load_tool(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, ROOT / "tools" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def build(target: str, out: Path) -> None:
    need("make", "cc")
    done = subprocess.run(
        ["make", "-C", str(FIRMWARE), target, f"OUT={out}"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="session")
def make_codec() -> ModuleType:
    return load_tool("make_codec")


@pytest.fixture(scope="session")
def make_vectors() -> ModuleType:
    return load_tool("make_vectors")


@pytest.fixture(scope="session")
def bench_library(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The core behind the HAL of port/bench, as ctypes sees it."""
    out = tmp_path_factory.mktemp("firmware")
    build("bench", out)
    return ctypes.CDLL(str(out / "bench.so"))
