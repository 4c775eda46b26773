# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamina: layered micro-facet materials for Blender's Cycles.

The same package runs as a Blender extension and, without Blender, as a Python library and the `lamina` command.
Only `register` and `unregister`, which Blender calls, import bpy.
"""


def version() -> str:
    """Lamina's version, from `blender_manifest.toml`, the only place that states it."""
    import tomllib
    from pathlib import Path

    return tomllib.loads((Path(__file__).parent / "blender_manifest.toml").read_text(encoding="utf-8"))["version"]


def register() -> None:
    """Add Lamina to the running Blender."""
    from .addon import registration

    registration.register()


def unregister() -> None:
    """Take out of the running Blender all that `register` added."""
    from .addon import registration

    registration.unregister()
