"""What ``snakebot doctor`` concludes from what it sees, on made-up computers."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from snakebot.doctor import host
from snakebot.doctor.board import RoundTrips, drift
from snakebot.doctor.finding import Finding, Status, percentile
from snakebot.doctor.port import (
    check_device,
    check_port,
    check_socketcan,
    latency_timer,
    modem_manager,
    who_has,
)
from snakebot.links import parse_port


def only(findings: list[Finding]) -> Finding:
    (finding,) = findings
    return finding


@pytest.mark.parametrize(("timer", "status"), [("16", Status.WARN), ("1", Status.OK), ("2", Status.WARN)])
def test_the_latency_timer_of_an_ftdi_adapter(tmp_path: Path, timer: str, status: Status) -> None:
    (tmp_path / "ttyUSB0").mkdir()
    (tmp_path / "ttyUSB0" / "latency_timer").write_text(f"{timer}\n")
    finding = only(latency_timer(Path("/dev/ttyUSB0"), tmp_path))
    assert finding.status is status
    assert finding.found.startswith(f"{timer} ms")
    assert ("latency_timer" in finding.advice) == (status is Status.WARN)


def test_other_adapters_have_no_latency_timer(tmp_path: Path) -> None:
    assert latency_timer(Path("/dev/ttyACM0"), tmp_path) == []


def test_modem_manager_matters_to_usb_devices_while_it_runs(tmp_path: Path) -> None:
    (tmp_path / "17").mkdir()
    (tmp_path / "17" / "comm").write_text("bash\n")
    assert modem_manager(Path("/dev/ttyACM0"), tmp_path) == []
    (tmp_path / "17" / "comm").write_text("ModemManager\n")
    assert only(modem_manager(Path("/dev/ttyACM0"), tmp_path)).status is Status.WARN
    assert modem_manager(Path("/dev/ttyS0"), tmp_path) == []


def can_interface(folder: Path, flags: int, queue: int) -> None:
    (folder / "can7").mkdir()
    (folder / "can7" / "flags").write_text(f"{flags:#x}\n")
    (folder / "can7" / "tx_queue_len").write_text(f"{queue}\n")


def test_a_can_interface_that_is_not_there(tmp_path: Path) -> None:
    assert only(check_socketcan("can7", tmp_path)).status is Status.FAIL


def test_a_can_interface_that_is_down_is_brought_up(tmp_path: Path) -> None:
    can_interface(tmp_path, 0x80, 10)
    finding = only(check_socketcan("can7", tmp_path))
    assert finding.status is Status.FAIL
    assert "ip link set can7 up" in finding.advice


def test_a_short_transmit_queue_is_lengthened(tmp_path: Path) -> None:
    can_interface(tmp_path, 0x81, 10)
    up, queue = check_socketcan("can7", tmp_path)
    assert up.status is Status.OK
    assert queue.status is Status.WARN
    assert "txqueuelen" in queue.advice


def test_a_long_enough_queue_needs_nothing(tmp_path: Path) -> None:
    can_interface(tmp_path, 0x81, 100)
    assert only(check_socketcan("can7", tmp_path)).status is Status.OK


def test_who_has_a_device_open() -> None:
    master, slave = os.openpty()
    path = Path(os.ttyname(slave))
    try:
        assert who_has(path) == []
        code = f"f = open({str(path)!r}, 'rb', 0); print(1, flush=True); input()"
        with subprocess.Popen(
            [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        ) as process:
            assert process.stdout is not None
            process.stdout.readline()
            assert [pid for pid, _ in who_has(path)] == [process.pid]
            uses = [f for f in check_device(str(path)) if f.what == "use"]
            assert only(uses).status is Status.WARN
            assert str(process.pid) in only(uses).found
    finally:
        os.close(slave)
        os.close(master)


def test_a_device_that_is_not_there_ends_the_examination() -> None:
    assert only(check_device("/dev/there-is-none")).status is Status.FAIL


@pytest.mark.parametrize("port", ["sim:", "can:virtual/x", "can:slcan/socket://a:1"])
def test_ports_with_nothing_to_look_at(port: str) -> None:
    assert check_port(parse_port(port)) == []


@pytest.mark.parametrize(
    ("source", "status"), [("tsc", Status.OK), ("hpet", Status.WARN), ("kvm-clock", Status.OK)]
)
def test_a_slow_clock_is_named(tmp_path: Path, source: str, status: Status) -> None:
    (tmp_path / "current_clocksource").write_text(f"{source}\n")
    (tmp_path / "available_clocksource").write_text("tsc hpet acpi_pm\n")
    finding = only(host.clock_source(tmp_path))
    assert finding.status is status
    assert source in finding.found


def test_a_processor_that_saves_power_is_named(tmp_path: Path) -> None:
    file = tmp_path / "scaling_governor"
    assert host.governor(file).status is Status.OK
    file.write_text("powersave\n")
    assert host.governor(file).status is Status.WARN
    file.write_text("performance\n")
    assert host.governor(file).status is Status.OK


def test_nearest_rank() -> None:
    values = [float(k) for k in range(100)]
    assert percentile(values, 0.5) == 50.0
    assert percentile(values, 0.99) == 99.0
    assert percentile([3.0], 0.99) == 3.0


@pytest.mark.parametrize("true_ppm", [-400.0, 0.0, 35.0, 500.0])
def test_drift_is_found_within_its_uncertainty(true_ppm: float) -> None:
    """Round trips of 0.3 ms to 5 ms whose delay is all on one leg: the worst case."""
    trips = RoundTrips([], [], [], 0)
    for k in range(300):
        trip_s = 0.0003 + 0.0047 * (k * 7919 % 100) / 100
        sent_s = 0.005 * k
        stamp_s = sent_s + (trip_s if k % 2 else 0.0)
        trips.trips_s.append(trip_s)
        trips.middle_s.append(sent_s + trip_s / 2)
        trips.board_s.append(77.0 + stamp_s * (1 + 1e-6 * true_ppm))
    found = drift(trips)
    assert found is not None
    drift_ppm, uncertainty_ppm = found
    assert abs(drift_ppm - true_ppm) <= uncertainty_ppm * 1.01
    assert uncertainty_ppm < 1000


def test_two_round_trips_tell_no_drift() -> None:
    assert drift(RoundTrips([0.1, 0.1], [0.0, 1.0], [0.0, 1.0], 0)) is None
