# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes one self-contained OSL shader for a stack from the parts in `osl/`. Does not need bpy.

A live tier's text depends on structure only (kinds, distributions, features): values come in through the shader's
parameters, stacks of one structure share one text, and moving a slider never changes it. A baked text holds the values.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from types import ModuleType

from ....reference_py.lobes.analytic import AnalyticLobes
from ....reference_py.lobes.analytic.brushed import BrushedLobes
from ....reference_py.lobes.cache import ALWAYS_LIVE
from ....reference_py.lobes.live_grid import LiveLobes
from ....reference_py.lobes.made import Made
from ....reference_py.lobes.methods.paper import PaperLobes
from ....reference_py.lobes.patch_lobes import PatchLobes
from ....reference_py.lobes.view_table import TableLobes
from ....reference_py.material.schema import SCHEMA, Schema
from ....reference_py.material.stack import Base, Layer, Stack
from ..inputs import BASE, PRIMARIES, TANGENT_INPUT, ShaderInput, layer_owner, owners_of, shader_inputs
from .block import Block, Share, shader_text


@dataclass(frozen=True)
class Shader:
    """A generated shader: its name (unique per text), its text, its inputs in order, its number of closures, and what sockets it has besides."""

    name: str
    text: str
    inputs: tuple[ShaderInput, ...]
    lobe_count: int
    others: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Emitter:
    """How lobe sets of one class are written: by a module of this folder, which is imported with the first of them and has a NOTE, and its block,
    for the owners of their layers and base, a suffix of names, and whether they only stand in."""

    file: str
    block: Callable[..., Block]
    reads_all: bool
    """Whether it reads all values live, and not only what its tables follow."""

    @property
    def module(self) -> ModuleType:
        return import_module(f".{self.file}", __package__)


_EMITTERS = {
    TableLobes: _Emitter("emit_tables", lambda emit, lobes, owners, suffix, _: emit.table_block(lobes, owners, suffix), False),
    LiveLobes: _Emitter("emit_live_grid", lambda emit, lobes, owners, suffix, _: emit.grid_block(lobes, owners, suffix), False),
    AnalyticLobes: _Emitter("emit_analytic", lambda emit, lobes, owners, _, stands_in: emit.analytic_block(lobes.stack, owners, stands_in), True),
    BrushedLobes: _Emitter("emit_analytic", lambda emit, lobes, owners, _, stands_in: emit.analytic_block(lobes.stack, owners, stands_in), True),
    PaperLobes: _Emitter("emit_paper", lambda emit, lobes, owners, *_: emit.weidlich_wilkie_block(lobes.stack, owners), True),
}


def generate(made: Made, schema: Schema = SCHEMA) -> Shader:
    """The shader of what `make_lobe_set` made. Raises LaminaError for more layers than Cycles can take."""
    stack = made.stack
    if isinstance(made.lobe_set, PatchLobes):
        parts = [(owners_of(patch), patch.covered, part.lobe_set) for patch, part in made.lobe_set.parts]
        pools = made.lobe_set.pools
    else:
        parts = [([*map(layer_owner, range(len(stack.layers))), BASE], (), made.lobe_set)]
        pools = {}
    emitters = [_EMITTERS[type(part)] for *_, part in parts]
    is_live = any(emitter.reads_all for emitter in emitters)
    followed = {place for owners, _, part in parts for place in _followed(part, owners)}
    followed |= {(TANGENT_INPUT.owner, TANGENT_INPUT.parameter.name) for *_, part in parts if isinstance(part, TableLobes | LiveLobes) and part.is_brushed}
    inputs = tuple(i for i in shader_inputs(stack, schema) if is_live or i.parameter.name in ALWAYS_LIVE or (i.owner, i.parameter.name) in followed)
    blocks = []
    for number, ((owners, covered, part), emitter) in enumerate(zip(parts, emitters)):
        own = {i: pool for (patch, i), pool in pools.items() if patch == number}
        share = Share(tuple((layer_owner(i), there) for i, there in covered), own)
        blocks.append((share, emitter.block(emitter.module, part, owners, f"{number}_" if len(parts) > 1 else "", made.stands_in)))
    title = f"Lamina shader, tier {made.method}, from the top: {_words(stack)}." if is_live else f"Lamina shader, tier {made.method}."
    body, closures = shader_text(title, " ".join(dict.fromkeys(emitter.module.NOTE for emitter in emitters)), blocks, inputs)
    name = "lamina_" + hashlib.sha256(body.encode()).hexdigest()[:12]
    return Shader(name, body.replace("@SHADER@", name), inputs, closures, ("Live", *PRIMARIES))


def _followed(lobe_set: LiveLobes | TableLobes, owners: list[str]) -> list[tuple[str, str]]:
    """The owners and names of what tables follow."""
    return [(owners[-1 if place.layer is None else place.layer], place.name) for place in lobe_set.followed]


def _words(stack: Stack) -> str:
    return ", ".join(_word(element) for element in (*stack.layers, stack.base))


def _word(element: Layer | Base) -> str:
    return element.kind + (f" ({element['distribution']})" if "distribution" in element else "")
