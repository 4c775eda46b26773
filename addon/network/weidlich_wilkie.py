# SPDX-License-Identifier: GPL-3.0-or-later
"""The shader body of the tier `weidlich_wilkie`: every value comes in through a parameter."""

from ...reference_py.network.weidlich_wilkie import MIN_COS_O, NODE_COUNT, nodes
from ...reference_py.optics.material import TINT_FLOOR
from ...reference_py.stack import Stack
from .inputs import ShaderInput, layer_owner
from .parts import beckmann, declaration, fill, listed, narrow, numbers, right_nested

def weidlich_wilkie_text(stack: Stack, inputs: tuple[ShaderInput, ...]) -> str:
    """The text of the shader, its name still @SHADER@."""
    count = len(stack.layers)
    surfaces = range(count)
    # OSL has no empty arrays: an uncoated base carries one unused surface
    return fill(
        "weidlich_wilkie.osl",
        TITLE=_title(stack),
        FUNCTIONS=_functions(stack),
        PARAMETERS="\n".join(declaration(i.osl_name, i.parameter) for i in inputs),
        MEDIA=count + 1,
        INDICES="".join(f", {layer_owner(i)}Ior" for i in surfaces),
        SURFACES=max(count, 1),
        ALPHAS=listed(f"{layer_owner(i)}Roughness * {layer_owner(i)}Roughness" for i in surfaces) or "0.0",
        BECKMANNS=listed(beckmann(layer) for layer in stack.layers) or "0",
        TAUS=listed(f"optical_depth({layer_owner(i)}Tint, {layer_owner(i)}Thickness)" for i in surfaces) or "color(0.0)",
        MIN_COS_O=f"{MIN_COS_O:g}",
        TANGENT=fill("tangent.osl") if _has_glossy(stack) else "",
        LOBES="".join(_lobes(stack)),
        SUM=right_nested([f"lobe_{i}" for i in range(count + 1)]),
    )


def _title(stack: Stack) -> str:
    parts = [f"{layer.kind} ({layer['distribution']})" for layer in stack.layers]
    parts.append(stack.base.kind + (f" ({stack.base['distribution']})" if "distribution" in stack.base else ""))
    return f"Lamina shader, tier weidlich_wilkie, from the top: {', '.join(parts)}."


def _functions(stack: Stack) -> str:
    """The parts that this structure calls, each once, callees first."""
    texts = []
    conductor = stack.base.kind == "conductor"
    if _has_glossy(stack):
        texts.append(narrow())
        texts += [fill("fresnel_dielectric.h"), fill("masking.h"), fill("carried.h")]
    if stack.layers:
        texts.append(fill("medium.h", TINT_FLOOR=f"{TINT_FLOOR:g}"))
    if len(stack.layers) > 1:
        texts.append(_weight_glossy("float eta", "fresnel_dielectric(inner_h, eta)"))
    if conductor:
        texts.append(fill("fresnel_conductor.h"))
        texts.append(_weight_glossy("color eta, color k", "fresnel_conductor(inner_h, eta, k)"))
        if "reflectance" in stack.base:
            texts.append(fill("artist_index.h"))
    elif stack.layers:
        texts.append(fill("weight_diffuse.h", NODE_COUNT=NODE_COUNT, NODES=_node_arrays()))
    return "\n".join(texts)


def _has_glossy(stack: Stack) -> bool:
    return bool(stack.layers) or stack.base.kind == "conductor"


def _weight_glossy(parameters: str, fresnel: str) -> str:
    return fill(
        "weight_glossy.h", NODE_COUNT=NODE_COUNT, NODES=_node_arrays(), FRESNEL_PARAMETERS=parameters, FRESNEL=fresnel
    )


def _node_arrays() -> str:
    names = ("node_u", "node_cos_phi", "node_weight")
    rows = (f"    float {name}[{NODE_COUNT}] = {{{numbers(values)}}};" for name, values in zip(names, nodes()))
    return "\n".join(rows)


def _lobes(stack: Stack) -> list[str]:
    lobes = []
    for index, layer in enumerate(stack.layers):
        part = "lobe_interface.osl" if index else "lobe_dielectric.osl"
        lobes.append(fill(part, INDEX=index, DISTRIBUTION=layer["distribution"], BECKMANN=beckmann(layer)))
    base, index = stack.base, len(stack.layers)
    if base.kind == "conductor":
        lobes.append(
            fill(
                "lobe_conductor.osl",
                INDEX=index,
                DISTRIBUTION=base["distribution"],
                BECKMANN=beckmann(base),
                BASE_INDEX=fill("index_artist.osl" if "reflectance" in base else "index_complex.osl"),
            )
        )
    else:
        sigma = "base_sigma" if base.kind == "oren_nayar" else "0.0"
        left = f"weight_diffuse({index}, n, alpha, beckmann, tau, view_z, {sigma})" if stack.layers else "color(1.0)"
        lobes.append(fill(f"lobe_{base.kind}.osl", INDEX=index, LEFT=left))
    return lobes
