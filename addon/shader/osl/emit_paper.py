# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tier `weidlich_wilkie` writes for a stack: every value comes in through a parameter."""

from collections.abc import Sequence

from ....reference_py.lobes.methods.paper import NODE_COUNT, nodes
from ....reference_py.material.schema import THIN_FILM
from ....reference_py.material.stack import Stack
from ....reference_py.optics.interface import TINT_FLOOR
from ....reference_py.optics.thin_film import THINNEST_NM
from ..inputs import BASE
from .block import Block, Closure
from .film import FILM, NO_FILM, FilmWords, film_arguments, film_arrays, film_functions, film_table, has_film
from .parts import beckmann, fill, listed, numbers
from .surface import BaseClosures, Surface, diffuse_closures, surface_of, top_closure, top_function

NOTE = 'Layered after Weidlich and Wilkie 2007, "Arbitrarily Layered Micro-Facet Surfaces".'


def weidlich_wilkie_block(stack: Stack, owners: Sequence[str]) -> Block:
    """The block of a stack whose layers' shader parameters begin with `owners`."""
    film = has_film(stack)
    surfaces = [surface_of(element, owner) for element, owner in zip((*stack.layers, stack.base), (*owners, BASE))]
    base = _base_closures(stack, surfaces[-1])
    return Block(
        functions=(*(text for surface in surfaces for text in surface.functions), *base.functions, *_functions(stack)),
        arrays=(film_table(),) if film else (),
        common=(*(text for surface in surfaces for text in surface.common), *base.common),
        body=_body(stack, owners, surfaces),
        closures=(*(_interface_closure(stack, i, *told) for i, told in enumerate(zip(surfaces[:-1], owners))), *base.closures),
    )


def _body(stack: Stack, owners: Sequence[str], surfaces: Sequence[Surface]) -> str:
    if not stack.layers and stack.base.kind != "conductor":
        return ""
    # OSL has no empty arrays: an uncoated metal carries one unused surface
    return fill(
        "weidlich_wilkie.osl",
        MEDIA=len(owners) + 1,
        INDICES="".join(f", {owner}Ior" for owner in owners),
        SURFACES=max(len(owners), 1),
        ALPHAS=listed(surface.alpha for surface in surfaces[:-1]) or "0.0",
        BECKMANNS=listed(beckmann(layer) for layer in stack.layers) or "0",
        FILMS=film_arrays(stack, owners),
        TAUS=listed(f"optical_depth({owner}Tint, {owner}Thickness)" for owner in owners) or "color(0.0)",
    )


def _functions(stack: Stack) -> list[str]:
    """The parts that this structure calls, callees first."""
    texts = []
    film = FILM if has_film(stack) else NO_FILM
    if stack.layers or stack.base.kind == "conductor":
        texts += [fill("fresnel_dielectric.h"), fill("masking.h")]
        if has_film(stack):
            texts.append(film_functions())
        texts.append(fill("carried.h", T12=f"{film.type} t12 = 1.0 - {film.reflectance};", **film.words))
    if stack.layers:
        texts.append(top_function(stack.layers[0]))
        texts.append(fill("medium.h", TINT_FLOOR=f"{TINT_FLOOR:g}"))
    if len(stack.layers) > 1:
        if any(layer.has(THIN_FILM) for layer in stack.layers[1:]):
            fresnel = "interface_reflectance(sensitivity, film_nm[depth], film_ior[depth], inner_h, n[depth], n[depth + 1])"
        else:
            fresnel = "fresnel_dielectric(inner_h, n[depth + 1] / n[depth])"
        texts.append(_weight_glossy(film, "", fresnel))
    if stack.base.kind == "conductor":
        texts.append(fill("fresnel_conductor.h"))
        fresnel = "fresnel_conductor(inner_h, eta / n[depth], k / n[depth])"
        if stack.base.has(THIN_FILM):
            fresnel = (
                f"(film_nm[depth] <= {THINNEST_NM:g} ? {fresnel} : film_reflectance(sensitivity, film_nm[depth], film_ior[depth], inner_h, n[depth], eta, k))"
            )
        texts.append(_weight_glossy(film, ", color eta, color k", fresnel))
        if "reflectance" in stack.base:
            texts.append(fill("artist_index.h"))
    elif stack.layers:
        texts.append(fill("weight_diffuse.h", NODE_COUNT=NODE_COUNT, NODES=_node_arrays(), **film.words))
    return texts


def _weight_glossy(film: FilmWords, parameters: str, fresnel: str) -> str:
    return fill(
        "weight_glossy.h",
        NODE_COUNT=NODE_COUNT,
        NODES=_node_arrays(),
        FRESNEL_PARAMETERS=parameters,
        FRESNEL=fresnel,
        **film.words,
    )


def _node_arrays() -> str:
    names = ("node_u", "node_cos_phi", "node_weight")
    rows = (f"    float {name}[{NODE_COUNT}] = {{{numbers(values)}}};" for name, values in zip(names, nodes()))
    return "\n".join(rows)


def _interface_closure(stack: Stack, index: int, surface: Surface, owner: str) -> Closure:
    layer = stack.layers[index]
    if index == 0:  # the closure has the exact Fresnel curve: nothing is folded
        return Closure("", top_closure(surface, layer, owner))
    weight = f"weight_glossy({index}, alpha[{index}], {beckmann(layer)}, n, alpha, beckmann, tau, {film_arguments(stack)}{surface.view})"
    return Closure(weight, surface.microfacet(layer["distribution"]))


def _base_closures(stack: Stack, surface: Surface) -> BaseClosures:
    base, count = stack.base, len(stack.layers)
    carried = f"n, alpha, beckmann, tau, {film_arguments(stack)}{surface.view}"
    if base.kind == "conductor":
        weight = f"weight_glossy({count}, {surface.alpha}, {beckmann(base)}, {carried}, base_eta, base_k)"
        index = fill("index_artist.osl" if "reflectance" in base else "index_complex.osl")
        return BaseClosures((Closure(weight, surface.microfacet(base["distribution"])),), common=(index,))
    diffuse = diffuse_closures(base, surface)
    sigma = "base_sigma" if base.kind == "oren_nayar" else "0.0"
    return diffuse.below(f"weight_diffuse({count}, {carried}, {sigma})") if count else diffuse
