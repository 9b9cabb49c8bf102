#!/usr/bin/env python3
"""Run a command on a real SocketCAN bus (vcan), in an emulated Linux with this computer's files.

For computers whose kernel has no CAN. Needs `qemu-system-x86_64`, `busybox` (static) and the package of a Debian
kernel, for example:

  apt-get install --no-install-recommends qemu-system-x86 busybox-static
  apt-get download linux-image-6.1.0-56-amd64
  tools/vcan_guest.py --kernel linux-image-*.deb -- .venv/bin/python -m pytest tests/links/test_socketcan.py

The guest sees all files of the host read-only but for /tmp, has an interface vcan0, no network, and ends with the
command, whose exit status becomes ours. Emulated time is good for right or wrong, not for how fast.
"""

from __future__ import annotations

import argparse
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

MODULES = ("virtio_pci", "9pnet_virtio", "9p", "overlay", "can_raw", "can_bcm", "vcan")
STATUS = "COMMAND ENDED WITH"
INIT = """#!/bin/busybox sh
/bin/busybox mkdir -p /proc /sys /host
/bin/busybox mount -t proc none /proc
/bin/busybox mount -t sysfs none /sys
while read module; do /bin/busybox insmod /modules/$module; done < /modules/order
/bin/busybox mount -t 9p -o trans=virtio,version=9p2000.L,msize=262144,cache=loose,ro root /host
/bin/busybox mount -t proc none /host/proc
/bin/busybox mount -t sysfs none /host/sys
/bin/busybox mount -t devtmpfs none /host/dev
/bin/busybox mkdir -p /host/dev/pts /host/dev/shm
/bin/busybox mount -t devpts none /host/dev/pts
/bin/busybox mount -t tmpfs none /host/dev/shm
/bin/busybox mount -t tmpfs none /host/tmp
exec /bin/busybox chroot /host /bin/sh -c '{command}'
"""


def unpack(package: Path, folder: Path) -> tuple[Path, Path]:
    """The kernel image and the folder of its modules."""
    subprocess.run(["dpkg-deb", "-x", package, folder], check=True)
    (image,) = (folder / "boot").glob("vmlinuz-*")
    (modules,) = (folder / "lib" / "modules").iterdir()
    return image, modules


def in_order(modules: Path, wanted: tuple[str, ...]) -> list[Path]:
    """The files of these modules and of all that they need, in the order in which they can be loaded."""
    files = {path.name.removesuffix(".ko").replace("-", "_"): path for path in modules.rglob("*.ko")}
    ordered: list[Path] = []

    def add(name: str) -> None:
        path = files.get(name.replace("-", "_"))
        if path is None or path in ordered:  # built into the kernel, or done
            return
        depends = re.search(rb"\0depends=([^\0]*)\0", path.read_bytes())
        for needed in (depends[1].decode() if depends else "").split(","):
            if needed:
                add(needed)
        ordered.append(path)

    for name in wanted:
        add(name)
    return ordered


def make_initramfs(folder: Path, modules: list[Path], command: str) -> Path:
    """A root of busybox, the modules, and an init that goes over to the host's files."""
    busybox = shutil.which("busybox")
    if busybox is None:
        sys.exit("vcan_guest: busybox is missing: apt-get install busybox-static")
    root = folder / "root"
    (root / "bin").mkdir(parents=True)
    (root / "modules").mkdir()
    shutil.copy(busybox, root / "bin" / "busybox")
    for module in modules:
        shutil.copy(module, root / "modules" / module.name)
    (root / "modules" / "order").write_text("".join(f"{module.name}\n" for module in modules))
    init = root / "init"
    init.write_text(INIT.replace("{command}", command))
    init.chmod(0o755)
    image = folder / "initramfs.cpio"
    with image.open("wb") as file:
        names = "\n".join(str(path.relative_to(root)) for path in sorted(root.rglob("*")))
        subprocess.run(
            [busybox, "cpio", "-o", "-H", "newc"], input=names.encode(), stdout=file, cwd=root, check=True
        )
    return image


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--kernel", type=Path, required=True, help="a Debian package linux-image-*.deb")
    parser.add_argument("--timeout-s", type=float, default=600.0)
    parser.add_argument("command", nargs="+")
    options = parser.parse_args()
    script = (
        "ip link add dev vcan0 type vcan; ip link set vcan0 up txqueuelen 100; ip link set lo up; "
        "export HOME=/tmp PYTHONDONTWRITEBYTECODE=1 PATH=/usr/sbin:/usr/bin:/sbin:/bin; "
        f"cd {shlex.quote(os.getcwd())}; "
        f"{shlex.join(options.command)}; echo {STATUS} $?; "
        "sync; echo o > /proc/sysrq-trigger; while true; do true; done"
    )
    if "'" in script:
        sys.exit("vcan_guest: give a command and a folder without quotes or spaces")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        image, modules = unpack(options.kernel, folder / "kernel")
        initramfs = make_initramfs(folder, in_order(modules, MODULES), script)
        guest = subprocess.Popen(
            [
                *("qemu-system-x86_64", "-m", "2048", "-smp", "2"),
                *("-cpu", "max"),  # compiled code in caches was made for this computer's processor
                *("-display", "none", "-monitor", "none", "-serial", "stdio"),
                *("-no-reboot", "-kernel", image, "-initrd", initramfs),
                *("-append", "console=ttyS0 quiet panic=-1"),
                *("-virtfs", "local,path=/,mount_tag=root,security_model=none,readonly=on,multidevs=remap"),
            ],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            text=True,
            errors="replace",
        )
        status = 1
        assert guest.stdout is not None
        try:
            for line in guest.stdout:
                if STATUS in line:
                    status = int(line.rsplit(maxsplit=1)[-1])
                else:
                    print(line, end="", flush=True)
            guest.wait(options.timeout_s)
        finally:
            guest.kill()
    sys.exit(status)


if __name__ == "__main__":
    main()
