# SPDX-License-Identifier: GPL-3.0-or-later
"""What a click would do once, done before it while nothing else happens. Changes no data of Blender's."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from importlib import import_module

import bpy

from ...reference_py.errors import LaminaError
from ...reference_py.lobes.cache import prepare
from ...reference_py.lobes.methods import holds_values, make_lobe_set, provisional
from ...reference_py.lobes.methods.not_bakeable import scatters
from ...reference_py.material.ready_layers import layers_of
from ...reference_py.material.schema import CONDUCTOR, DIELECTRIC, LAMBERT
from ...reference_py.material.stack import Stack
from ..blender import environment
from ..shader.nodes.stock_nodes import eevee_stock_tables, stock_tables
from ..shader.osl.generate import generate
from .backend import OSL, branches_here
from .reading import stack_of
from .script_node import compile_shader

_PLAIN = layers_of({"layers": [{"kind": DIELECTRIC.name}]}, "a plain layer")


def pieces() -> Iterator[None]:
    """Each step takes some hundredths of a second: the compiler's modules, the digest that bakes are found by, and the tables that shaders share."""
    if environment.osl_available()[0]:
        import_module("cycles.osl")
        import_module("oslquery")
        yield
    prepare()
    yield
    for base in (LAMBERT, CONDUCTOR):
        made = provisional(Stack.from_dict({"layers": [{"kind": DIELECTRIC.name}], "base": {"kind": base.name}}))
        yield
        generate(made)
        yield
        eevee_stock_tables(made, stock_tables(made))
        yield


def compile_next(material: bpy.types.Material) -> None:
    """Compile the script of a layered material with one more plain layer above the selected one: half of the time of the click that adds it.

    A layer of another kind or with features, and one over a medium that scatters, is compiled when it comes.
    """
    lamina = material.lamina
    if OSL not in branches_here(lamina.backend):
        return
    above = sum(lamina.shows(layer) for layer in lamina.layers[: lamina.active_layer])
    with suppress(LaminaError):  # the click tells it
        stack = stack_of(material)
        stack = replace(stack, layers=(*stack.layers[:above], *_PLAIN, *stack.layers[above:]))
        if not scatters(stack):
            compile_shader(generate(provisional(stack) if holds_values(lamina.tier) else make_lobe_set(stack, lamina.tier)))
