# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamina's version."""

from pathlib import Path

MANIFEST = Path(__file__).parents[1] / "blender_manifest.toml"


def version() -> str:
    """The version that `blender_manifest.toml` states, the only place that does."""
    import tomllib  # takes as long to import as ten of our own modules

    return tomllib.loads(MANIFEST.read_text(encoding="utf-8"))["version"]
