# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes of a bundle, each at the same relative place to copies of all files that it reads."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path, PurePath

import bpy

from ...reference_py.errors import LaminaError
from ..blender.blend_files import open_file, refuse_missing, save_copy
from ..blender.dependencies import files_read, missing, named


class SceneFiles:
    """Writes into `folder`/scenes. `name` gives a short name to any text."""

    def __init__(self, folder: Path, name: Callable[[str], str], allow_missing: bool, report: Callable[[str], None]):
        self._folder, self._name, self._allow_missing, self._report = folder, name, allow_missing, report
        self._sizes: dict[Path, int] = {}
        self._saved: list[str] = []

    def save(self, blend: str, key: str) -> str:
        """Save the open scene, which is a .blend's unless that is empty; returns its place in the bundle. Raises LaminaError, OSError."""
        stem = self._name(key)
        if not blend:
            file = f"scenes/{stem}.blend"
            save_copy(self._folder / file)
            return file
        files = [path for path in files_read() if os.path.isfile(path)]
        root = _root(blend, files)
        tree = self._folder / "scenes" / self._name(root)
        caches = Path(blend).with_name(f"blendcache_{Path(blend).stem}")
        pairs = []
        for path in map(Path, files):
            # a simulation's default folder is named after the .blend
            place = caches.with_name(f"blendcache_{stem}") / path.relative_to(caches) if path.is_relative_to(caches) else path
            pairs.append((path, tree / os.path.relpath(place, root)))
        self._copy(pairs)
        target = tree / os.path.relpath(Path(blend).with_name(f"{stem}.blend"), root)
        target.parent.mkdir(parents=True, exist_ok=True)
        if bpy.utils.blend_paths(packed=True):
            bpy.ops.file.make_paths_relative()
        save_copy(target, remap=False)
        self._saved.append(target.relative_to(self._folder).as_posix())
        return self._saved[-1]

    def _copy(self, pairs: list[tuple[Path, Path]]) -> None:
        new = {target: source for source, target in pairs if target not in self._sizes}
        sizes = {target: source.stat().st_size for target, source in new.items()}
        free = shutil.disk_usage(self._folder).free
        if sum(sizes.values()) > free:
            raise LaminaError(f"the scenes read {_megabytes(sum(sizes.values()))} of files, and this disk has {_megabytes(free)} free")
        for target, source in new.items():
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)
        self._sizes |= sizes

    def verify(self) -> None:
        """Open what was saved, as a farm will: all that it reads must lie in the bundle. Raises LaminaError. Closes the open scene."""
        home = os.path.normpath(self._folder.resolve())
        for file in self._saved:
            open_file(self._folder / file)
            outside = [path for path in files_read() if not PurePath(path).is_relative_to(home)]
            if outside:
                raise LaminaError(
                    f"what a library of the scene names by an absolute path cannot be taken along: {named(outside)}; "
                    "make the paths of that library relative (File, External Data) and save it"
                )
            refuse_missing(PurePath(file).name, missing(), self._allow_missing, lambda _: None)
        if self._sizes:
            self._report(f"copied {len(self._sizes)} files that the scenes read, {_megabytes(sum(self._sizes.values()))}")


def _root(blend: str, files: list[str]) -> str:
    try:
        return os.path.commonpath([os.path.dirname(blend), *map(os.path.dirname, files)])
    except ValueError:
        drive = os.path.splitdrive(blend)[0]
        other = next(path for path in files if os.path.splitdrive(path)[0] != drive)
        raise LaminaError(f"{other} is on another drive than {blend}, and Blender knows no relative path between them; put it on the same") from None


def _megabytes(size: int) -> str:
    return f"{size / 1e6:.2f} MB"
