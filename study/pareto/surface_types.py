# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface types of the chart: one preset or stack of the suite for each. Does not need bpy."""

from ...reference_py.errors import LaminaError
from ...reference_py.material import presets
from ...reference_py.material.stack import Stack
from ..suite import suite

SURFACES = {
    "glazed_mug": "Painted: smooth coat over Lambert",
    "frosted_paint": "Frosted paint: rough coat over Lambert",
    "metallic_car_paint": "Car paint: smooth tinted coat over metal",
    "frosted_metal": "Frosted metal: rough tinted coat over metal",
    "three_rough": "Three rough interfaces over gold",
    "clean_copper": "Bare metal: copper",
}


def load_surface(name: str) -> Stack:
    """The stack of a preset or of the suite. Raises LaminaError on an unknown name."""
    if name in presets.names():
        return presets.load(name)
    if name in suite():
        return suite()[name]
    raise LaminaError(f"unknown surface {name!r}; choose {', '.join((*presets.names(), *suite()))}")


def label(name: str) -> str:
    return SURFACES.get(name, name)
