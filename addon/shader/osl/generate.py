# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes one self-contained OSL shader for a stack from the parts in `osl/`. Does not need bpy.

A live tier's text depends on structure only (kinds, distributions, features): values come in through the shader's
parameters, stacks of one structure share one text, and moving a slider never changes it. A baked text holds the values.
"""

import hashlib
from dataclasses import dataclass

from ....reference_py.lobes.cache import ALWAYS_LIVE
from ....reference_py.lobes.live_grid import GridNetwork
from ....reference_py.lobes.methods import AnalyticNetwork
from ....reference_py.lobes.patch_lobes import PatchNetwork
from ....reference_py.lobes.view_table import TableNetwork
from ....reference_py.material.schema import SCHEMA, Schema
from ....reference_py.material.stack import Element, Stack
from ..inputs import BASE, PRIMARIES, ShaderInput, layer_owner, shader_inputs
from . import emit_analytic, emit_live_grid, emit_paper, emit_tables
from .block import Block, Share, shader_text


@dataclass(frozen=True)
class Shader:
    """A generated shader: its name (unique per text), its text, its inputs in order, its number of closures, and what sockets it has besides."""

    name: str
    text: str
    inputs: tuple[ShaderInput, ...]
    lobe_count: int
    others: tuple[str, ...] = ()


def generate(network, schema: Schema = SCHEMA) -> Shader:
    """The shader of a network (`make_network`). Raises LaminaError for more layers than Cycles can take."""
    told = network.resolved
    stack = network.stack
    if isinstance(told, PatchNetwork):
        parts = [(patch.layers, patch.covered, part.resolved) for patch, part in told.parts]
    else:
        parts = [(tuple(range(len(stack.layers))), (), told)]
    is_live = any(not isinstance(part, TableNetwork | GridNetwork) for _, _, part in parts)
    followed = {(owner, axis.parameter) for layers, _, part in parts if isinstance(part, GridNetwork) for owner, axis in _axes(part, layers)}
    inputs = tuple(
        i for i in shader_inputs(stack, schema) if is_live or i.parameter.name in ALWAYS_LIVE or (i.owner, i.parameter.name) in followed
    )
    blocks = []
    for number, (layers, covered, part) in enumerate(parts):
        share = Share(tuple((layer_owner(i), there) for i, there in covered))
        blocks.append((share, _block(part, [layer_owner(i) for i in layers], f"{number}_" if len(parts) > 1 else "")))
    title = f"Lamina shader, tier {network.tier}, from the top: {_words(stack)}." if is_live else f"Lamina shader, tier {network.tier}."
    body, closures = shader_text(title, _note(parts), blocks, inputs)
    name = "lamina_" + hashlib.sha256(body.encode()).hexdigest()[:12]
    return Shader(name, body.replace("@SHADER@", name), inputs, closures, ("Live", *PRIMARIES))


def _axes(network: GridNetwork, layers: tuple[int, ...]):
    return [(BASE if axis.index < 0 else layer_owner(layers[axis.index]), axis) for axis in network.axes]


def _block(network, owners: list[str], prefix: str) -> Block:
    if isinstance(network, TableNetwork):
        return emit_tables.table_block(network, prefix)
    if isinstance(network, GridNetwork):
        return emit_live_grid.grid_block(network, owners, prefix)
    if isinstance(network, AnalyticNetwork):
        return emit_analytic.analytic_block(network.stack, owners)
    return emit_paper.weidlich_wilkie_block(network.stack, owners)


def _note(parts) -> str:
    notes = []
    for *_, part in parts:
        module = emit_tables if isinstance(part, TableNetwork) else emit_live_grid if isinstance(part, GridNetwork) else emit_analytic if isinstance(part, AnalyticNetwork) else emit_paper
        notes.append(module.NOTE)
    return " ".join(dict.fromkeys(notes))


def _words(stack: Stack) -> str:
    return ", ".join(_word(element) for element in (*stack.layers, stack.base))


def _word(element: Element) -> str:
    return element.kind + (f" ({element['distribution']})" if "distribution" in element else "")
