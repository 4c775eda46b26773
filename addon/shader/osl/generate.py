# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes one self-contained OSL shader for a stack from the parts in `osl/`. Does not need bpy.

A live tier's text depends on structure only (kinds, distributions, features): values come in through the shader's
parameters, stacks of one structure share one text, and moving a slider never changes it. A baked text holds the values.
"""

import hashlib
from dataclasses import dataclass

from ....reference_py.lobes.cache import ALWAYS_LIVE
from ....reference_py.lobes.live_grid import LiveLobes
from ....reference_py.lobes.methods import AnalyticLobes
from ....reference_py.lobes.patch_lobes import PatchLobes
from ....reference_py.lobes.view_table import TableLobes
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


def generate(lobe_set, schema: Schema = SCHEMA) -> Shader:
    """The shader of a lobe set (`make_lobe_set`). Raises LaminaError for more layers than Cycles can take."""
    resolved = lobe_set.resolved
    stack = lobe_set.stack
    if isinstance(resolved, PatchLobes):
        parts = [(patch.layers, patch.covered, part.resolved) for patch, part in resolved.parts]
    else:
        parts = [(tuple(range(len(stack.layers))), (), resolved)]
    is_live = any(not isinstance(part, TableLobes | LiveLobes) for _, _, part in parts)
    followed = {(owner, axis.parameter) for layers, _, part in parts if isinstance(part, LiveLobes) for owner, axis in _axes(part, layers)}
    inputs = tuple(i for i in shader_inputs(stack, schema) if is_live or i.parameter.name in ALWAYS_LIVE or (i.owner, i.parameter.name) in followed)
    blocks, notes = [], []
    for number, (layers, covered, part) in enumerate(parts):
        note, block = _block(part, [layer_owner(i) for i in layers], f"{number}_" if len(parts) > 1 else "")
        blocks.append((Share(tuple((layer_owner(i), there) for i, there in covered)), block))
        notes.append(note)
    title = f"Lamina shader, tier {lobe_set.tier}, from the top: {_words(stack)}." if is_live else f"Lamina shader, tier {lobe_set.tier}."
    body, closures = shader_text(title, " ".join(dict.fromkeys(notes)), blocks, inputs)
    name = "lamina_" + hashlib.sha256(body.encode()).hexdigest()[:12]
    return Shader(name, body.replace("@SHADER@", name), inputs, closures, ("Live", *PRIMARIES))


def _axes(lobe_set: LiveLobes, layers: tuple[int, ...]):
    return [(BASE if axis.index < 0 else layer_owner(layers[axis.index]), axis) for axis in lobe_set.axes]


def _block(lobe_set, owners: list[str], prefix: str) -> tuple[str, Block]:
    """What a lobe set writes, and the note that its shader bears."""
    if isinstance(lobe_set, TableLobes):
        return emit_tables.NOTE, emit_tables.table_block(lobe_set, prefix)
    if isinstance(lobe_set, LiveLobes):
        return emit_live_grid.NOTE, emit_live_grid.grid_block(lobe_set, owners, prefix)
    if isinstance(lobe_set, AnalyticLobes):
        return emit_analytic.NOTE, emit_analytic.analytic_block(lobe_set.stack, owners)
    return emit_paper.NOTE, emit_paper.weidlich_wilkie_block(lobe_set.stack, owners)


def _words(stack: Stack) -> str:
    return ", ".join(_word(element) for element in (*stack.layers, stack.base))


def _word(element: Element) -> str:
    return element.kind + (f" ({element['distribution']})" if "distribution" in element else "")
