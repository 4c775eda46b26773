# SPDX-License-Identifier: GPL-3.0-or-later
"""What this Blender can do: is it the bpy wheel, and does it have OSL?"""

import importlib.util
import sys
from pathlib import Path

from ...reference_py.errors import Sentence

# Why there may be no OSL.
NO_CYCLES, NO_OSL = Sentence("this Blender has no Cycles"), Sentence("this Blender was built without OSL")
NO_QUERY = Sentence("Python cannot import oslquery, so Script nodes would get no sockets")


def is_wheel() -> bool:
    """True when Blender runs as a Python module (`pip install bpy`) and not as an application."""
    import bpy

    return bool(bpy.app.module)


def ensure_osl_query_on_path() -> None:
    """Make `oslquery` importable in the bpy wheel; does nothing in a real Blender.

    The wheel ships oslquery and OpenImageIO in a folder that is not on sys.path. Without it Script nodes get no
    sockets and render white, with no error. Only the command line and the tests may call this: extensions
    must not edit sys.path, and in a real Blender there is no need to.

    The folder goes last, so that it never hides an installed package.
    """
    import bpy

    if not is_wheel() or importlib.util.find_spec("oslquery"):
        return
    python = Path(bpy.utils.resource_path("LOCAL")) / "python" / "lib"
    folder = python / f"python{sys.version_info.major}.{sys.version_info.minor}" / "site-packages"
    if folder.is_dir():
        sys.path.append(str(folder))
        importlib.invalidate_caches()


def renders_osl() -> bool:
    """Whether Cycles here was built with OSL. Where it was not, it renders Script nodes as nothing and says nothing."""
    try:
        import _cycles
    except ImportError:
        return False
    return _cycles.with_osl


def osl_available() -> tuple[bool, str]:
    """Whether OSL Script nodes can be built and rendered here, and one sentence that says why (not)."""
    try:
        import _cycles
    except ImportError:
        return False, NO_CYCLES
    if not renders_osl():
        return False, NO_OSL
    if importlib.util.find_spec("oslquery") is None:
        return False, NO_QUERY
    return True, f"OSL {_cycles.osl_version_string}"
