"""The fuzz corpus of the firmware in one archive: hundreds of small files would be most of the repository's paths.

The archive is made deterministically: the same inputs give the same bytes, whoever packs them and when.
"""

from __future__ import annotations

import io
import lzma
import shutil
import tarfile
from pathlib import Path


def pack(folder: Path, archive: Path) -> None:
    """Write the files of a folder into ``archive`` (.tar.xz), sorted by name, without owners or times."""
    plain = io.BytesIO()
    with tarfile.open(fileobj=plain, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for path in sorted(folder.iterdir()):
            data = path.read_bytes()
            entry = tarfile.TarInfo(path.name)  # mode 0644, owner 0, time 0
            entry.size = len(data)
            tar.addfile(entry, io.BytesIO(data))
    part = archive.with_name(archive.name + ".part")
    part.write_bytes(lzma.compress(plain.getvalue(), preset=9))
    part.replace(archive)


def unpack(archive: Path, folder: Path) -> Path:
    """Lay the inputs of ``archive`` out in ``folder``, which then holds nothing else. Returns the folder."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    with tarfile.open(archive, "r:xz") as tar:
        # files of one folder; Python before 3.11.4 has no filter to keep all of a tar in it
        for entry in tar:
            data = tar.extractfile(entry)
            assert data is not None
            (folder / Path(entry.name).name).write_bytes(data.read())
    return folder
