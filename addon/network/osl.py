# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes one self-contained OSL shader for a stack from the parts in `osl/`. Does not need bpy.

A live tier's text depends on structure only (kinds, distributions): values come in through the shader's parameters,
stacks of one structure share one text, and moving a slider never changes it. A baked text holds the values.
"""

import hashlib
from dataclasses import dataclass

from ...reference_py.network import AnalyticNetwork, make_network
from ...reference_py.network.table import TableNetwork
from ...reference_py.schema import SCHEMA, Schema
from ...reference_py.stack import Stack
from .analytic import analytic_text
from .inputs import ShaderInput, shader_inputs
from .table import table_text
from .weidlich_wilkie import weidlich_wilkie_text


@dataclass(frozen=True)
class Shader:
    """A generated shader: its name (unique per text), its text and its inputs in order."""

    name: str
    text: str
    inputs: tuple[ShaderInput, ...]


def generate(stack: Stack, tier: str, schema: Schema = SCHEMA) -> Shader:
    """The shader of a stack in the given tier (a key of `TIERS`). Raises LaminaError for more layers than Cycles can take."""
    network = make_network(stack, tier).resolved
    if isinstance(network, TableNetwork):
        inputs: tuple[ShaderInput, ...] = ()
        body = table_text(network, f"Lamina shader, tier {tier}, {network.lobe_count} closures.")
    else:
        inputs = shader_inputs(stack, schema)
        body = (analytic_text if isinstance(network, AnalyticNetwork) else weidlich_wilkie_text)(stack, inputs)
    name = "lamina_" + hashlib.sha256(body.encode()).hexdigest()[:12]
    return Shader(name, body.replace("@SHADER@", name), inputs)
