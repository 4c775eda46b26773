# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamina: layered micro-facet materials for Blender's Cycles.

The same package runs as a Blender extension and, without Blender, as a Python library and the `lamina` command.
Only `register` and `unregister`, which Blender calls, import bpy.
"""

# Kept for unregister: Blender gives the command as a handle.
_command = None


def register() -> None:
    """Add Lamina to the running Blender, and the command `blender --command lamina ...`."""
    global _command
    import bpy

    from .addon.later import import_later

    import_later()  # before what imports these modules
    from .addon import registration

    registration.register()
    _command = bpy.utils.register_cli_command("lamina", _run)


def _run(arguments: list[str]) -> int:
    """The command, which nobody waits for when Blender starts."""
    from .addon.cli.main import run

    return run(arguments)


def unregister() -> None:
    """Take out of the running Blender all that `register` added."""
    import bpy

    from .addon import registration

    bpy.utils.unregister_cli_command(_command)
    registration.unregister()
