# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tier `weidlich_wilkie` writes for a stack: every value comes in through a parameter."""

from collections.abc import Sequence
from functools import cache

import numpy as np

from ....reference_py.lobes.methods.paper import NODE_COUNT, nodes
from ....reference_py.material.schema import THIN_FILM
from ....reference_py.material.stack import Stack
from ....reference_py.optics.thin_film import sensitivities
from .block import Block, Closure, numbers
from .surface import BaseClosures, Surface, base_name, beckmann, diffuse_closures, is_metal, is_rough, metal_closure, surface_of, top_closure, top_function

NOTE = 'Layered after Weidlich and Wilkie 2007, "Arbitrarily Layered Micro-Facet Surfaces".'


def weidlich_wilkie_block(stack: Stack, owners: Sequence[str]) -> Block:
    """The block of a stack whose shader parameters begin with `owners`, those of the layers and of the base."""
    surfaces = [surface_of(element, owner) for element, owner in zip((*stack.layers, stack.base), owners)]
    base = _base_closures(stack, surfaces[-1], owners[-1])
    return Block(
        functions=(*(name for surface in surfaces for name in surface.functions), *base.functions, *_functions(stack)),
        arrays=(*([_nodes()] if _has_weights(stack) else []), *([_film_table()] if _has_film(stack) else [])),
        common=(*(text for surface in surfaces for text in surface.common), *base.common),
        body=_body(stack, owners, surfaces),
        closures=(*(_interface_closure(stack, i, *pair) for i, pair in enumerate(zip(surfaces[:-1], owners[:-1]))), *base.closures),
    )


def _has_weights(stack: Stack) -> bool:
    """Whether the shader computes a weight: all closures but that of a top interface and of a bare diffuse base have one."""
    return bool(stack.layers) or is_metal(stack)


def _has_film(stack: Stack) -> bool:
    """Whether a shader of the stack has to compute with films; that on the top interface alone is its closure's, but all
    that lies below sees light that has passed it."""
    return any(element.has(THIN_FILM) for element in (*stack.layers, stack.base))


def _functions(stack: Stack) -> list[str]:
    """The files that this structure calls."""
    film = "_film" if _has_film(stack) else ""
    names = [top_function(stack.layers[0]), "medium.h"] if stack.layers else []
    if len(stack.layers) > 1:
        names.append(f"weight_glossy{film}.h")
    if is_metal(stack):
        names.append(f"weight_metal{film}.h")
    elif stack.layers:
        names.append(f"weight_diffuse{film}.h")
    return names


def _body(stack: Stack, owners: Sequence[str], surfaces: Sequence[Surface]) -> tuple[str, ...]:
    """Absolute indices from vacuum down, microfacet widths and optical depths per interface, and films of all surfaces."""
    if not _has_weights(stack):
        return ()
    # OSL has no empty arrays: an uncoated metal carries one unused surface
    lines = [
        _array("float", "n", ["1.0", *(f"{owner}Ior" for owner in owners[:-1])]),
        _array("float", "alpha", [surface.alpha for surface in surfaces[:-1]] or ["0.0"]),
        _array("int", "beckmann", [beckmann(layer) for layer in stack.layers] or ["0"]),
        _array("color", "tau", [f"optical_depth({owner}Tint, {owner}Thickness)" for owner in owners[:-1]] or ["color(0.0)"]),
    ]
    if _has_film(stack):
        films = [owner if element.has(THIN_FILM) else "" for element, owner in zip((*stack.layers, stack.base), owners)]
        lines.append(_array("float", "film_nm", [f"{owner}FilmThickness" if owner else "0.0" for owner in films]))
        lines.append(_array("float", "film_ior", [f"{owner}FilmIor" if owner else "1.0" for owner in films]))
    return tuple(lines)


def _array(osl_type: str, name: str, entries: list[str]) -> str:
    return f"{osl_type} {name}[{len(entries)}] = {{{', '.join(entries)}}};"


@cache
def _nodes() -> str:
    """The array parameter of the fixed facets and directions over which weights are averaged."""
    values = np.concatenate(nodes())
    return f"float Nodes[{3 * NODE_COUNT}] = {{{numbers(values)}}}"


@cache
def _film_table() -> str:
    """The array parameter of the channels' sensitivities."""
    parts = np.concatenate([sensitivities().real.T, sensitivities().imag.T]).ravel()
    return f"float FilmSensitivity[{parts.size}] = {{{','.join([f'{v:.5g}' for v in np.round(parts, 5) + 0.0])}}}"


def _interfaces(stack: Stack) -> str:
    """What weights are given of the interfaces above."""
    return "n, alpha, beckmann, tau" + (", FilmSensitivity, film_nm, film_ior" if _has_film(stack) else "")


def _interface_closure(stack: Stack, index: int, surface: Surface, owner: str) -> Closure:
    layer = stack.layers[index]
    if index == 0:  # the closure has the exact Fresnel curve: nothing is folded
        return Closure("", top_closure(surface, layer, owner))
    weight = f"weight_glossy(Nodes, {index}, alpha[{index}], {beckmann(layer)}, {_interfaces(stack)}, {surface.view})"
    return Closure(weight, surface.microfacet(layer["distribution"]))


def _base_closures(stack: Stack, surface: Surface, owner: str) -> BaseClosures:
    base, count = stack.base, len(stack.layers)
    above = f"{_interfaces(stack)}, {surface.view}"
    if is_metal(stack):
        weight = f"weight_metal(Nodes, {count}, {surface.alpha}, {beckmann(base)}, {above}, {base_name(owner, 'eta')}, {base_name(owner, 'k')})"
        return metal_closure(base, owner, Closure(weight, surface.microfacet(base["distribution"])))
    diffuse = diffuse_closures(base, surface, owner)
    sigma = base_name(owner, "sigma") if is_rough(base) else "0.0"
    return diffuse.below(f"weight_diffuse(Nodes, {count}, {above}, {sigma})") if count else diffuse
