# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender need not import when it starts: modules that are imported when something of them is first asked for.

Once an artist sees the panel they are read one by one between the window's events (`read_soon`), and what they compute once
for a session is computed (`material.first_click`), so that the first click waits for none. What registers classes, draws and
listens imports these as modules (`from ..material import reading`), never names out of them, and so costs Blender's start
neither numpy nor the reference. Where `import_later` was not called, as on the command line, they are imported as ever.
"""

import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.util import find_spec, module_from_spec
from types import ModuleType

MODULES = (
    "addon/check/check",
    "addon/exchange/conversion",
    "addon/exchange/mask_bake",
    "addon/exchange/materialx_import",
    "addon/exchange/selection_export",
    "addon/exchange/sources",
    "addon/exchange/textures",
    "addon/jobs/prefetch",
    "addon/library/preset_assets",
    "addon/library/preset_process",
    "addon/material/chosen",
    "addon/material/elements",
    "addon/material/entry",
    "addon/material/first_click",
    "addon/material/hand_over",
    "addon/material/kind_groups",
    "addon/material/layers",
    "addon/material/live_values",
    "addon/material/mask_links",
    "addon/material/material",
    "addon/material/osl_setting",
    "addon/material/pasted",
    "addon/material/principled_node",
    "addon/material/reading",
    "addon/material/record",
    "addon/material/replaced",
    "addon/material/roles",
    "addon/material/shader_node",
    "addon/material/state",
    "addon/shader/working_space",
    "addon/ui/swatch",
    "addon/ui/value_notes",
    "reference_py/exchange/conversion_process",
    "reference_py/exchange/hand_over",
    "reference_py/exchange/materialx",
    "reference_py/exchange/openpbr",
    "reference_py/exchange/report",
    "reference_py/fit/fit_process",
    "reference_py/fit/forward",
    "reference_py/fit/metric",
    "reference_py/lobes/methods",
    "reference_py/optics/colour",
    "reference_py/optics/microfacet",
)


# Seconds between two of them: events of the window come first.
_BETWEEN = 0.02


class _Unread(ModuleType):
    """A module whose text is run when a name is asked for that it has not.

    `importlib.util.LazyLoader` runs it for any name, `__dict__` too, which Blender asks of all modules when it quits.
    """

    def __getattr__(self, name: str):
        if name.startswith("__"):
            raise AttributeError(name)
        _read(self)
        return getattr(self, name)


def _read(module: ModuleType) -> None:
    module.__class__ = ModuleType
    module.__spec__.loader.exec_module(module)


def read_soon() -> Callable[[], float | None]:
    """A timer that reads an unread module, or does a piece of the first click's work, whenever it is called.

    Returns the seconds to the next call, None once all is done.
    """
    package = __package__.rpartition(".")[0]
    names = [f"{package}.{path.replace('/', '.')}" for path in MODULES]

    def steps() -> Iterator[None]:
        for name in names:
            if type(sys.modules.get(name)) is _Unread:
                _read(sys.modules[name])
                yield
        from .material import first_click

        yield from first_click.pieces()

    left = steps()
    return lambda: next((_BETWEEN for _ in left), None)


def import_later() -> None:
    """Put the modules that are not there yet in their places, unread."""
    package = __package__.rpartition(".")[0]
    for path in MODULES:
        full = f"{package}.{path.replace('/', '.')}"
        if full not in sys.modules:
            parent, _, own = full.rpartition(".")
            module = sys.modules[full] = module_from_spec(find_spec(full))
            module.__class__ = _Unread
            setattr(import_module(parent), own, module)
