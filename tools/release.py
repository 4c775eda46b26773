# SPDX-License-Identifier: GPL-3.0-or-later
"""What a release needs beside the zip, checked and put together: `make release`.

    release.py FOLDER ZIP     write into FOLDER the release's notes and the listing for Blender's extensions platform

The sizes are those that the platform's forms ask for; its texts are the manifest's, and what Blender's own tool checks of them `make validate`
has checked. Says every fault in one line, and writes nothing where there is one.
"""

import re
import shutil
import struct
import sys
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CHANGELOG, LISTING = "CHANGELOG.md", "tools/listing"
DESCRIPTION, ICON, FEATURED = f"{LISTING}/description.md", f"{LISTING}/icon.png", f"{LISTING}/featured.jpg"
ICON_SIZE, FEATURED_SIZE = (256, 256), (1920, 1080)
# The tagline and each permission's reason.
LONGEST = 64
MOST_MB = 200.0


def notes_of(changelog: str, version: str) -> str:
    """The section of a version; empty where it is not the first one."""
    found = re.search(r"^## (\S+).*?\n(.*?)(?=^## |\Z)", changelog, re.M | re.S)
    return found[2].strip() if found and found[1] == version else ""


def size_of(picture: bytes) -> tuple[int, int]:
    """Width and height of a PNG or JPEG; (0, 0) of anything else."""
    if picture[:8] == b"\x89PNG\r\n\x1a\n":
        return struct.unpack(">II", picture[16:24])
    place = 2
    while picture[:2] == b"\xff\xd8" and place + 9 <= len(picture):
        marker, length = picture[place + 1], int.from_bytes(picture[place + 2 : place + 4])
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack(">HH", picture[place + 5 : place + 9])
            return width, height
        place += 2 + length
    return (0, 0)


def faults(root: Path, archive: Path) -> list[str]:
    """What a release of the tree at `root` lacks, a line each."""
    manifest = tomllib.loads((root / "blender_manifest.toml").read_text(encoding="utf-8"))
    texts = {"tagline": manifest["tagline"]} | {f"permission {name}": reason for name, reason in manifest.get("permissions", {}).items()}
    found = [f"{name}: {len(text)} letters, at most {LONGEST}" for name, text in texts.items() if len(text) > LONGEST]
    found += [f"{name}: ends in {text[-1]!r}, which the platform refuses" for name, text in texts.items() if not text[-1:].isalnum() and text[-1:] != ")"]
    if not manifest.get("tags"):
        found.append("blender_manifest.toml: no tags")
    missing = [name for name in (CHANGELOG, DESCRIPTION, ICON, FEATURED) if not (root / name).is_file()]
    found += [f"{name}: is missing" for name in missing]
    if CHANGELOG not in missing and not notes_of((root / CHANGELOG).read_text(encoding="utf-8"), manifest["version"]):
        found.append(f"{CHANGELOG}: its first section is not that of version {manifest['version']}")
    for name, wanted in ((ICON, ICON_SIZE), (FEATURED, FEATURED_SIZE)):
        if name not in missing and (size := size_of((root / name).read_bytes())) != wanted:
            found.append(f"{name}: {size[0]} x {size[1]} pixels; the platform asks for {wanted[0]} x {wanted[1]}")
    if archive.name != f"{manifest['id']}-{manifest['version']}.zip":
        found.append(f"{archive.name}: is not of version {manifest['version']}")
    elif archive.stat().st_size > 1e6 * MOST_MB:
        found.append(f"{archive.name}: {archive.stat().st_size / 1e6:.0f} MB, at most {MOST_MB:.0f}")
    else:
        with zipfile.ZipFile(archive) as held:
            found += [f"{archive.name}: has no {name}" for name in ("LICENSE", "blender_manifest.toml", "manual/index.html") if name not in held.namelist()]
    return found


def main(folder: Path, archive: Path) -> int:
    if lines := faults(ROOT, archive):
        print("\n".join(f"release: {line}" for line in lines), file=sys.stderr)
        return 1
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"notes-{manifest['version']}.md").write_text(
        notes_of((ROOT / CHANGELOG).read_text(encoding="utf-8"), manifest["version"]) + "\n", encoding="utf-8"
    )
    for name in (DESCRIPTION, ICON, FEATURED):
        shutil.copy(ROOT / name, folder / Path(name).name)
    print(f"{archive.name}: {archive.stat().st_size / 1e6:.1f} MB; notes and listing in {folder}")
    return 0


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2])))
