"""What ``snakebot doctor`` looks at before it opens a port: device, rights, who has it, latency timer, bus settings."""

from __future__ import annotations

import os
from pathlib import Path

from snakebot.doctor.finding import Finding, Status, read_text
from snakebot.links.capacity import ip_details
from snakebot.links.port import CanPort, Port, SerialPort, ServoPort
from snakebot.links.serial_link import permission_advice

_SLOW_TIMER_MS = 1  # an FTDI adapter's latency timer above the least it can be set to
_ENOUGH_QUEUE = 32  # frames; sixteen joints need seven a tick


def check_port(port: Port) -> list[Finding]:
    """Findings that need no open port."""
    if isinstance(port, SerialPort):
        return _stream(port) if port.is_url else check_device(port.device)
    if isinstance(port, ServoPort):
        return check_device(port.device)
    if isinstance(port, CanPort):
        if port.interface == "socketcan":
            return check_socketcan(port.channel)
        device = port.channel.partition("@")[0]
        if port.interface in ("slcan", "robotell", "seeedstudio") and "://" not in device:
            return check_device(device)
    return []


def _stream(port: SerialPort) -> list[Finding]:
    return [Finding("line", Status.INFO, f"{port.device}: rights and timing are those of the far end")]


def check_device(device: str) -> list[Finding]:
    """A serial device: is it there, may we, who has it, how fast does its driver hand bytes on."""
    path = Path(device)
    if not path.exists():
        advice = "plug it in; `snakebot board list` shows what is there, `dmesg` what the kernel says"
        return [Finding("device", Status.FAIL, f"{device} is not there", advice)]
    findings = [_device(path), _rights(path)]
    users = who_has(path)
    if users:
        found = "open in " + ", ".join(f"{name} (process {pid})" for pid, name in users)
        findings.append(Finding("use", Status.WARN, found, "end it if the port cannot be opened"))
    else:
        findings.append(Finding("use", Status.OK, "nobody else has it open"))
    findings += latency_timer(path)
    findings += modem_manager(path)
    return findings


def _device(path: Path) -> Finding:
    from serial.tools import list_ports

    real = os.path.realpath(path)
    for port in list_ports.comports():
        if port.device in (str(path), real):
            parts = [port.manufacturer, port.product or port.description, port.serial_number]
            what = " ".join(part for part in parts if part and part != "n/a") or "serial port"
            return Finding("device", Status.OK, f"{path}: {what}")
    if real.startswith("/dev/pts/"):
        return Finding("device", Status.OK, f"{path}: a pseudo-terminal (a simulated board)")
    return Finding("device", Status.INFO, f"{path}: not an adapter that this system lists")


def _rights(path: Path) -> Finding:
    mode = path.stat()
    found = f"{_name_of(mode.st_uid, 'passwd')}:{_name_of(mode.st_gid, 'group')} {mode.st_mode & 0o777:o}"
    if os.access(path, os.R_OK | os.W_OK):
        return Finding("rights", Status.OK, f"may be opened ({found})")
    return Finding("rights", Status.FAIL, f"may not be opened ({found})", permission_advice(str(path)))


def _name_of(number: int, table: str) -> str:
    import grp
    import pwd

    try:
        return pwd.getpwuid(number).pw_name if table == "passwd" else grp.getgrgid(number).gr_name
    except KeyError:
        return str(number)


def who_has(path: Path, proc: Path = Path("/proc")) -> list[tuple[int, str]]:
    """(process, name) of those that have a device open, as far as this user may see.

    Who serves a pseudo-terminal (has its other side open too) is not counted.
    """
    real = os.path.realpath(path)
    found = []
    for process in proc.glob("[0-9]*"):
        if int(process.name) == os.getpid():
            continue
        try:
            files = {os.readlink(fd) for fd in (process / "fd").iterdir()}
        except OSError:  # another user's, or gone
            continue
        if real in files and not files & {"/dev/ptmx", "/dev/pts/ptmx"}:
            found.append((int(process.name), read_text(process / "comm") or "?"))
    return sorted(found)


def latency_timer(path: Path, sys: Path = Path("/sys/bus/usb-serial/devices")) -> list[Finding]:
    """FTDI adapters hold bytes back until a timer runs out: 16 ms as delivered."""
    name = Path(os.path.realpath(path)).name
    timer = sys / name / "latency_timer"
    text = read_text(timer)
    if text is None or not text.isdigit():
        return []
    if int(text) <= _SLOW_TIMER_MS:
        return [Finding("latency timer", Status.OK, f"{text} ms")]
    advice = (
        f"snakebot asks the driver for 1 ms when it opens the port; if round trips stay long: "
        f"`echo 1 | sudo tee {timer}`, permanently with a udev rule (docs/connect.md)"
    )
    return [Finding("latency timer", Status.WARN, f"{text} ms: each answer may wait that long", advice)]


def modem_manager(path: Path, proc: Path = Path("/proc")) -> list[Finding]:
    """ModemManager talks to any new serial device for a while."""
    if not os.path.realpath(path).startswith(("/dev/ttyUSB", "/dev/ttyACM")):
        return []
    if not any(read_text(process / "comm") == "ModemManager" for process in proc.glob("[0-9]*")):
        return []
    advice = "tell it to leave the adapter alone with a udev rule (docs/connect.md), or wait a minute after plugging in"
    return [Finding("ModemManager", Status.WARN, "is running and may talk to the board first", advice)]


def check_socketcan(channel: str, sys: Path = Path("/sys/class/net")) -> list[Finding]:
    """A SocketCAN interface: is it there, is it up, at which bit rate, how long is its queue."""
    folder = sys / channel
    if not folder.exists():
        advice = "plug the adapter in, `sudo modprobe can_raw`; a bus without hardware: docs/connect.md"
        return [Finding("interface", Status.FAIL, f"{channel} is not there", advice)]
    flags = int(read_text(folder / "flags") or "0", 16)
    details = ip_details(channel)
    bit_rate = details.get("bittiming", {}).get("bitrate")
    state = details.get("state", "")
    if not flags & 1:
        advice = f"`sudo ip link set {channel} up type can bitrate 1000000`"
        return [Finding("interface", Status.FAIL, f"{channel} is down", advice)]
    rate = f", {bit_rate} bit/s" if bit_rate else ""
    findings = [Finding("interface", Status.OK, f"{channel} is up{rate}")]
    if state and state != "ERROR-ACTIVE":
        advice = "errors on the bus: check bit rate, wiring and both 120 ohm resistors"
        findings.append(Finding("bus state", Status.FAIL, state, advice))
    queue = int(read_text(folder / "tx_queue_len") or "0")
    if queue < _ENOUGH_QUEUE:
        advice = f"`sudo ip link set {channel} txqueuelen 100`"
        findings.append(Finding("transmit queue", Status.WARN, f"{queue} frames", advice))
    return findings
