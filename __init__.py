# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamina: layered micro-facet materials for Blender's Cycles.

The same package runs as a Blender extension and, without Blender, as a Python library and the `lamina` command.
Only `register` and `unregister`, which Blender calls, import bpy. The names of `reference_py/api.py` are this package's own:

    import lamina
    stack = lamina.load("frosted_paint")
    lamina.albedo(stack, theta=[0, 30, 60])
"""

# Those of `reference_py/api.py`, which is read when one is asked for: Blender asks for none.
_API = ("Samples", "SpectralStack", "Stack", "albedo", "f", "load", "model", "models", "names", "sample", "spectral_stack", "spherical")

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


def __getattr__(name: str):
    if name not in _API:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from .reference_py import api

    return getattr(api, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_API})
