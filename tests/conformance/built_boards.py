"""The firmware built once, for every board of the conformance suite."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any

import pytest
from building import BUILD, core_library_path, make, need


@pytest.fixture(scope="session")
def core_library() -> Any:
    return ctypes.CDLL(str(core_library_path()))


@pytest.fixture(scope="session")
def host_program() -> Path:
    """The board as a Linux program, with address and undefined-behaviour sanitizers."""
    make("sanitized")
    return BUILD / "snakebot_board_sanitized"


@pytest.fixture(scope="session")
def cortex_m_image() -> Path:
    need("arm-none-eabi-gcc", "qemu-system-arm")
    make("cortex_m")
    return BUILD / "snakebot_cortex_m.elf"
