"""The tools that make the firmware's files, and the core with time in the test's hands."""

from __future__ import annotations

import ctypes
import importlib.util
from types import ModuleType
from typing import Any

import pytest
from building import ROOT, core_library_path


def load_tool(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, ROOT / "tools" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def make_codec() -> ModuleType:
    return load_tool("make_codec")


@pytest.fixture(scope="session")
def make_vectors() -> ModuleType:
    return load_tool("make_vectors")


@pytest.fixture(scope="session")
def bench_library() -> Any:
    """The core behind the HAL of port/bench, as ctypes sees it."""
    return ctypes.CDLL(str(core_library_path()))
