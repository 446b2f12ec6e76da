"""A report folder as one file, with checksums that tell whether all is there and unchanged."""

import hashlib
import os
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

SUMS = "SHA256SUMS"
CHUNK = 2**20
# Zip needs its later form above 2 GiB; a file may grow while it is read.
LARGE = 2**30


def write_archive(folder: Path) -> Path:
    """Write FOLDER.zip beside a folder, and return its path; raises OSError.

    It has a file of checksums as ``sha256sum --check`` reads it, whose last line says that it is
    complete. The archive has its name only once it is whole.
    """
    folder = folder.resolve()
    archive = folder.with_name(f"{folder.name}.zip")
    unfinished = folder.with_name(f"{archive.name}.part")
    files = [path for path in sorted(folder.rglob("*")) if _is_packed(path)]
    sums = []
    try:
        with ZipFile(unfinished, "w", ZIP_DEFLATED) as packed:
            for path in files:
                name = path.relative_to(folder).as_posix()
                sums.append(f"{_pack(packed, path, f'{folder.name}/{name}')}  {name}")
            sums.append(f"# complete: {len(files)} files")
            packed.writestr(f"{folder.name}/{SUMS}", "\n".join(sums) + "\n")
        os.replace(unfinished, archive)
    finally:
        unfinished.unlink(missing_ok=True)
    return archive


def _is_packed(path: Path) -> bool:
    """Leave out what leads elsewhere, and the checksums of an archive that was unpacked."""
    return path.is_file() and not path.is_symlink() and path.name != SUMS


def _pack(packed: ZipFile, path: Path, name: str) -> str:
    """Add a file; return its checksum, which is of the same bytes though the file may grow."""
    entry = ZipInfo.from_file(path, name, strict_timestamps=False)
    entry.compress_type = ZIP_DEFLATED
    digest = hashlib.sha256()
    large = path.stat().st_size > LARGE
    with path.open("rb") as file, packed.open(entry, "w", force_zip64=large) as target:
        while chunk := file.read(CHUNK):
            digest.update(chunk)
            target.write(chunk)
    return digest.hexdigest()
