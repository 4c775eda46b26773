# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamina's version."""

import tomllib
from pathlib import Path

MANIFEST = Path(__file__).parents[1] / "blender_manifest.toml"


def version() -> str:
    """The version that `blender_manifest.toml` states, the only place that does."""
    return tomllib.loads(MANIFEST.read_text(encoding="utf-8"))["version"]
