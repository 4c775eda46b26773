# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes one self-contained OSL shader for a stack's structure from the parts in `osl/`.

The text depends on structure only (kinds, distributions, tier); values come in through the shader's parameters.
Stacks of one structure share one text, and moving a slider never changes it. Does not need bpy.
"""

import hashlib
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from ...reference_py.errors import LaminaError
from ...reference_py.network import TIERS
from ...reference_py.network.weidlich_wilkie import MIN_COS_O, NODE_COUNT, nodes
from ...reference_py.optics.material import TINT_FLOOR
from ...reference_py.schema import COLOR, FLOAT, SCHEMA, Parameter, Schema
from ...reference_py.stack import Element, Stack

PARTS = Path(__file__).resolve().parents[2] / "osl"
BASE = "Base"
# Below this alpha a lobe takes Cycles' anisotropic path (osl/narrow.h); above it the isotropic one is within 1e-4.
NARROW_ALPHA = 0.06
# Blender 5.2 aborts on a shader of more than 128 parameters, the output among them.
MAX_INPUTS = 127


@dataclass(frozen=True)
class ShaderInput:
    """One shader parameter: its OSL name, whose it is ("Layer1", ..., "Base"), and its schema row."""

    osl_name: str
    owner: str
    parameter: Parameter


@dataclass(frozen=True)
class Shader:
    """A generated shader: its name (unique per text), its text and its inputs in order."""

    name: str
    text: str
    inputs: tuple[ShaderInput, ...]


def layer_owner(index: int) -> str:
    return f"Layer{index + 1}"


def used_sockets(element: Element, kind) -> tuple[Parameter, ...]:
    """The socket parameters that a shader of this element reads. A named metal is read as eta and k."""
    given = set(element.values)
    if "metal" in given:
        given |= {"eta", "k"}
    return tuple(p for p in kind.sockets if p.name in given)


def shader_inputs(stack: Stack, schema: Schema = SCHEMA) -> tuple[ShaderInput, ...]:
    """Every parameter of the shader of this stack, layers from the top, then the base."""
    owners = [(layer_owner(i), layer, schema.layers[layer.kind]) for i, layer in enumerate(stack.layers)]
    owners.append((BASE, stack.base, schema.bases[stack.base.kind]))
    return tuple(
        ShaderInput(owner + p.osl_name, owner, p) for owner, element, kind in owners for p in used_sockets(element, kind)
    )


def generate(stack: Stack, tier: str, schema: Schema = SCHEMA) -> Shader:
    """The shader of a stack's structure in the given tier (a key of `TIERS`).

    Raises LaminaError for more layers than Cycles can take.
    """
    assert tier in TIERS, tier
    inputs = shader_inputs(stack, schema)
    if len(inputs) > MAX_INPUTS:
        raise LaminaError(
            f"{len(stack.layers)} layers need {len(inputs)} shader parameters, and Cycles takes {MAX_INPUTS}; choose fewer layers"
        )
    count = len(stack.layers)
    surfaces = range(count)
    # OSL has no empty arrays: an uncoated base carries one unused surface
    body = _fill(
        "weidlich_wilkie.osl",
        TITLE=_title(stack, tier),
        FUNCTIONS=_functions(stack),
        PARAMETERS="\n".join(_declaration(i) for i in inputs),
        MEDIA=count + 1,
        INDICES="".join(f", {layer_owner(i)}Ior" for i in surfaces),
        SURFACES=max(count, 1),
        ALPHAS=_list(f"{layer_owner(i)}Roughness * {layer_owner(i)}Roughness" for i in surfaces) or "0.0",
        BECKMANNS=_list(_beckmann(layer) for layer in stack.layers) or "0",
        TAUS=_list(f"optical_depth({layer_owner(i)}Tint, {layer_owner(i)}Thickness)" for i in surfaces) or "color(0.0)",
        MIN_COS_O=f"{MIN_COS_O:g}",
        TANGENT=_fill("tangent.osl") if _has_glossy(stack) else "",
        LOBES="".join(_lobes(stack)),
        SUM=_right_nested([f"lobe_{i}" for i in range(count + 1)]),
    )
    name = "lamina_" + hashlib.sha256(body.encode()).hexdigest()[:12]
    return Shader(name, body.replace("@SHADER@", name), inputs)


def _title(stack: Stack, tier: str) -> str:
    parts = [f"{layer.kind} ({layer['distribution']})" for layer in stack.layers]
    parts.append(stack.base.kind + (f" ({stack.base['distribution']})" if "distribution" in stack.base else ""))
    return f"Lamina shader, tier {tier}, from the top: {', '.join(parts)}."


def _functions(stack: Stack) -> str:
    """The parts that this structure calls, each once, callees first."""
    texts = []
    conductor = stack.base.kind == "conductor"
    if _has_glossy(stack):
        texts.append(_fill("narrow.h", NARROW_ALPHA=f"{NARROW_ALPHA:g}"))
        texts += [_fill("fresnel_dielectric.h"), _fill("masking.h"), _fill("carried.h")]
    if stack.layers:
        texts.append(_fill("medium.h", TINT_FLOOR=f"{TINT_FLOOR:g}"))
    if len(stack.layers) > 1:
        texts.append(_weight_glossy("float eta", "fresnel_dielectric(inner_h, eta)"))
    if conductor:
        texts.append(_fill("fresnel_conductor.h"))
        texts.append(_weight_glossy("color eta, color k", "fresnel_conductor(inner_h, eta, k)"))
        if "reflectance" in stack.base:
            texts.append(_fill("artist_index.h"))
    elif stack.layers:
        texts.append(_fill("weight_diffuse.h", NODE_COUNT=NODE_COUNT, NODES=_node_arrays()))
    return "\n".join(texts)


def _has_glossy(stack: Stack) -> bool:
    return bool(stack.layers) or stack.base.kind == "conductor"


def _weight_glossy(parameters: str, fresnel: str) -> str:
    return _fill(
        "weight_glossy.h", NODE_COUNT=NODE_COUNT, NODES=_node_arrays(), FRESNEL_PARAMETERS=parameters, FRESNEL=fresnel
    )


def _node_arrays() -> str:
    names = ("node_u", "node_cos_phi", "node_weight")
    rows = (f"    float {name}[{NODE_COUNT}] = {{{_list(f'{v:.9g}' for v in values)}}};" for name, values in zip(names, nodes()))
    return "\n".join(rows)


def _lobes(stack: Stack) -> list[str]:
    lobes = []
    for index, layer in enumerate(stack.layers):
        part = "lobe_interface.osl" if index else "lobe_dielectric.osl"
        lobes.append(_fill(part, INDEX=index, DISTRIBUTION=layer["distribution"], BECKMANN=_beckmann(layer)))
    base, index = stack.base, len(stack.layers)
    if base.kind == "conductor":
        lobes.append(
            _fill(
                "lobe_conductor.osl",
                INDEX=index,
                DISTRIBUTION=base["distribution"],
                BECKMANN=_beckmann(base),
                BASE_INDEX=_fill("index_artist.osl" if "reflectance" in base else "index_complex.osl"),
            )
        )
    else:
        sigma = "base_sigma" if base.kind == "oren_nayar" else "0.0"
        left = f"weight_diffuse({index}, n, alpha, beckmann, tau, view_z, {sigma})" if stack.layers else "color(1.0)"
        lobes.append(_fill(f"lobe_{base.kind}.osl", INDEX=index, LEFT=left))
    return lobes


def _beckmann(element: Element) -> str:
    return "1" if element["distribution"] == "beckmann" else "0"


def _declaration(shader_input: ShaderInput) -> str:
    parameter = shader_input.parameter
    if parameter.type == FLOAT:
        return f"    float {shader_input.osl_name} = {parameter.default:.9g},"
    osl_type = "color" if parameter.type == COLOR else "vector"
    return f"    {osl_type} {shader_input.osl_name} = {osl_type}({_list(f'{v:.9g}' for v in parameter.default)}),"


def _right_nested(names: list[str]) -> str:
    head, *tail = names
    return f"{head} + ({_right_nested(tail)})" if len(tail) > 1 else " + ".join(names)


def _list(items) -> str:
    return ", ".join(items)


@cache
def _part(name: str) -> str:
    """A part's text without its licence line, which the assembled shader states once."""
    lines = (PARTS / name).read_text(encoding="utf-8").splitlines(keepends=True)
    return "".join(line for line in lines if "SPDX-License-Identifier" not in line)


def _fill(name: str, **values) -> str:
    text = _part(name)
    for key, value in values.items():
        text = text.replace(f"@{key}@", str(value))
    return text
