# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a measured table comes from, in one line: commit, Blender, numpy and date. Imports nothing of Lamina, so that tools can use it alone."""

import subprocess
import sys
from datetime import date
from importlib.metadata import version
from pathlib import Path

ROOT = Path(__file__).parents[1]
BEGINNING = "commit "


def stamp(*versions: str) -> str:
    """E.g. "commit 1a2b3c4+changes; Blender 4.5.15 LTS; numpy 1.26.4; 2026-11-28".

    `versions` stand in the place of this process's own, where others did the work.
    """
    return "; ".join((BEGINNING + commit(), *(versions or (blender_version(), numpy_version())), date.today().isoformat()))


def is_stamp(text: str) -> bool:
    """Whether a cell of a heading is a stamp."""
    return text.startswith(BEGINNING)


def commit() -> str:
    """Short hash, "+changes" where anything but figures/ differs from it (a table that is written makes none); "unknown" outside of git."""
    head = _git("rev-parse", "--short", "HEAD")
    return head + "+changes" * bool(_git("status", "--porcelain", "--", ".", ":(exclude)figures")) if head else "unknown"


def blender_version() -> str:
    """The Blender of this process; "no Blender" where it was never needed."""
    bpy = sys.modules.get("bpy")
    return f"Blender {bpy.app.version_string}" if bpy else "no Blender"


def module_blender() -> str:
    """The Blender that processes of their own import as the module bpy, as this one may not."""
    return f"Blender {version('bpy')}"


def numpy_version() -> str:
    """The numpy of this process."""
    import numpy

    return f"numpy {numpy.__version__}"


def _git(*arguments: str) -> str:
    """What git prints of this checkout; nothing without git, or where it knows no checkout."""
    try:
        return subprocess.run(["git", "-C", ROOT, *arguments], capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""
