# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina cache`: what bakes take on the disk."""

import json

from ...reference_py.errors import LaminaError
from ...reference_py.lobes.cache import clean, usage
from ..blender.user_folders import cache_folder


def cache(options) -> None:
    """Print folder, files, bytes, hits and ages; or remove what is kept."""
    folder = cache_folder()
    if options.older_than is not None and not options.clean:
        raise LaminaError("--older-than goes with --clean")
    if folder.exists() and not folder.is_dir():
        raise LaminaError(f"{folder}: this is a file; bakes are kept in a folder")
    if options.clean:
        gone = clean(folder, options.older_than or 0.0)
        print(
            json.dumps({"removed": gone.files, "bytes": gone.size}) if options.json else f"removed {gone.files} files, {gone.size / 1e6:.2f} MB, from {folder}"
        )
        return
    held = usage(folder)
    if options.json:
        print(json.dumps({"folder": str(folder), **held._asdict()}))
        return
    print(f"folder  {folder}{'' if folder.is_dir() else ' (not made yet)'}")
    print(f"files   {held.files}")
    print(f"bytes   {held.size} ({held.size / 1e6:.2f} MB)")
    print(f"hits    {held.hits}")
    print(f"unused  for {held.newest_days:.1f} to {held.oldest_days:.1f} days")
