# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tier `analytic` writes for a stack: every value comes in through a parameter, tables are an array parameter.

Of a stack's features, an anisotropic surface has the energy of the view's azimuth (reference_py/lobes/methods/with_features.py); a layer with
a normal of its own has the energy of that normal's view.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ....reference_py.lobes.analytic import base
from ....reference_py.lobes.analytic.lobe_set import ALBEDO_NODES
from ....reference_py.material.schema import ANISOTROPY
from ....reference_py.material.stack import Element, Stack
from ....reference_py.optics.interface import TINT_FLOOR
from ..inputs import BASE
from .analytic_layers import beam_of, below_text, for_each, layers_text, lines_of, roughest, view_text
from .analytic_tables import Tables, constants
from .block import Block, Closure
from .parts import beckmann, fill
from .surface import BaseClosures, Surface, diffuse_closures, surface_of, top_closure, top_function

NOTE = "Adding over the interfaces at every shading point."


def analytic_block(stack: Stack, owners: Sequence[str]) -> Block:
    """The block of a stack whose layers' shader parameters begin with `owners`."""
    surfaces = [surface_of(element, owner) for element, owner in zip((*stack.layers, stack.base), (*owners, BASE))]
    told = Tables.of(stack)
    body, closures = [], []
    if stack.layers:
        body.append(layers_text(stack, owners, surfaces, told))
        seen = "alpha_0"
        if stack.layers[0].has(ANISOTROPY):
            seen, top = "alpha_seen", surfaces[0]
            body.append(fill("analytic_seen.osl", OWNER=owners[0], ALPHA_X=top.alpha_x, ALPHA_Y=top.alpha_y, VIEW=top.view))
        body += [view_text(stack, told, view, seen) for view in dict.fromkeys((surfaces[1].view, surfaces[-1].view))]
        weight = f"top_gain({told.arguments(stack.layers[0]['distribution'])}, {surfaces[0].view}, {seen}, n_1)"
        closures.append(Closure(weight, top_closure(surfaces[0], stack.layers[0], owners[0])))
    if len(stack.layers) > 1:
        layer, surface = stack.layers[1], surfaces[1]
        lobe = _Lobe.of(layer, surface, owners[1], "inner", "n_1", told)
        body.append(fill("analytic_inner.osl", BEAM=beam_of(surface.view), VIEW=surface.view, WIDTHS=lobe.widths, CLOSURE_ENERGY=lobe.energy))
        closures.append(Closure("weight_inner", lobe.closure, is_local=True))
    text, base_closures = _metal(stack, surfaces[-1], told) if stack.base.kind == "conductor" else _diffuse(stack, surfaces[-1])
    return Block(
        functions=(*(text for surface in surfaces for text in surface.functions), *base_closures.functions, *_functions(stack)),
        arrays=told.arrays,
        common=(*(text for surface in surfaces for text in surface.common), *_azimuths(stack, owners, surfaces), *base_closures.common),
        body="".join([*body, text]),
        closures=(*closures, *base_closures.closures),
    )


def _functions(stack: Stack) -> list[str]:
    """The parts that this structure calls, callees first."""
    texts = []
    brushed = any(element.has(ANISOTROPY) for element in (*stack.layers, stack.base))
    if stack.layers or stack.base.kind == "conductor":
        texts += [constants(brushed), fill("fresnel_dielectric.h"), fill("analytic_tables.h"), fill("analytic_cosine.h")]
    if brushed:
        texts.append(fill("analytic_brushed.h"))
    if stack.layers:
        texts.append(top_function(stack.layers[0]))
        texts += [fill("medium.h", TINT_FLOOR=f"{TINT_FLOOR:g}"), fill("analytic_beam.h"), fill("analytic_lobe.h")]
        if any(element.has(ANISOTROPY) for element in (*stack.layers[1:2], stack.base)):
            texts.append(fill("brushed.h"))
        if stack.base.kind == "oren_nayar":
            texts.append(fill("oren_nayar_albedo.h"))
    if stack.base.kind == "conductor":
        mean = " + ".join(f"{w:g} * fresnel_conductor({c:g}, eta, k)" for c, w in zip(base.MEAN_COSINES, base.MEAN_WEIGHTS))
        texts += [fill("masking.h"), fill("fresnel_conductor.h"), fill("analytic_metal.h", MEAN=mean)]
        if stack.base.has(ANISOTROPY):
            texts.append(fill("analytic_brushed_metal.h"))
        if stack.layers:
            texts += [fill("analytic_below.h", **below_text()), fill("analytic_coated_metal.h")]
        if "reflectance" in stack.base:
            texts.append(fill("artist_index.h"))
    return texts


def _azimuths(stack: Stack, owners: Sequence[str], surfaces: Sequence[Surface]) -> list[str]:
    told = zip((*stack.layers, stack.base), (*owners, BASE), surfaces)
    return [fill("analytic_azimuth.osl", OWNER=owner, NORMAL=surface.normal) for element, owner, surface in told if element.has(ANISOTROPY)]


@dataclass(frozen=True)
class _Lobe:
    """What leaves an element below others: statements of its widths, its closure, and the directional albedo of that."""

    widths: str
    closure: str
    energy: str

    @classmethod
    def of(cls, element: Element, surface: Surface, owner: str, name: str, n: str | None, told: Tables) -> "_Lobe":
        """The lobe of width `alpha_{name}` of an element below index n, or bare: along its axes as far as the width is its own."""
        alpha, kind = f"alpha_{name}", element["distribution"]
        table = told.arguments(kind)
        if not element.has(ANISOTROPY):
            shaped = surface if n is None else replace(surface, alpha_x=alpha, alpha_y=f"across({alpha})")
            return cls("", shaped.microfacet(kind), f"closure_energy({table}, {surface.view}, {alpha})")
        statements = []
        if n is not None:
            own = {f"alpha_x_{name}": surface.alpha_x, f"alpha_y_{name}": surface.alpha_y}
            for lobe_alpha, width in own.items():
                value = f"brushed_alpha({alpha}, {surface.alpha}, {width} / max({surface.alpha}, 1e-12), {n}, {surface.view})"
                statements.append(f"    float {lobe_alpha} = {value};\n")
            surface = replace(surface, **dict(zip(("alpha_x", "alpha_y"), own)))
        return cls("".join(statements), surface.microfacet(kind), _brushed_energy(table, surface.view, owner, surface))


def _brushed_energy(table: str, cosine: str, owner: str, surface: Surface) -> str:
    return f"brushed_energy({table}, {cosine}, cos_2phi_{owner}, {surface.alpha_x}, {surface.alpha_y})"


def _diffuse(stack: Stack, surface: Surface) -> tuple[str, BaseClosures]:
    """Statements for the weight of a diffuse base, and its closures."""
    closures = diffuse_closures(stack.base, surface)
    if not stack.layers:
        return "", closures
    beam = beam_of(surface.view)
    if stack.base.kind == "lambert":
        return "", closures.below(f"{beam}.transmitted * escaped / (1.0 - BaseColor * reflected)")
    u, w = base.gauss(ALBEDO_NODES)
    mean = " + ".join(f"{2.0 * wi * ui:.9g} * oren_nayar_albedo({ui:.9g}, BaseColor, base_sigma)" for ui, wi in zip(u, w))
    text = fill("analytic_oren_nayar.osl", BEAM=beam, VIEW=surface.view, N_BASE=f"n_{len(stack.layers)}", MEAN=mean)
    return text, closures.below("weight_base")


def _metal(stack: Stack, surface: Surface, told: Tables) -> tuple[str, BaseClosures]:
    """The same of a metal base."""
    element, count = stack.base, len(stack.layers)
    table = told.arguments(element["distribution"])
    if count:
        n, beam = f"n_{count}", beam_of(surface.view)
        arrives = f"{beam}.p, {beam}.variance"
        energy = f"{beam}.transmitted * metal_energy(lobe, facets, keep, {surface.alpha}, {roughest(count)}, reflected, escaped)"
        alpha = f"lobe_alpha(2.0 * {beam}.variance + pow(2.0 * {n} * lobe.c * {surface.alpha}, 2.0), {surface.view})"
    else:
        n, arrives, energy = "1.0", f"sqrt(1.0 - {surface.view} * {surface.view}), 0.0", "(lobe.once * keep + facets)"
        alpha = surface.alpha
    lobe = _Lobe.of(element, surface, BASE, "base", n if count else None, told)
    facet_energy, brushed = f"closure_energy({table}, lobe.c, {surface.alpha})", ""
    if element.has(ANISOTROPY):
        facet_energy = _brushed_energy(table, "lobe.c", BASE, surface)
        brushed = f"    facets = later_brushed_facets(facets, lobe, facet_energy, {surface.alpha_x}, {surface.alpha_y});\n"
    text = fill(
        "analytic_conductor.osl",
        N_BASE=n,
        ARRIVES=arrives,
        SURFACE_ALPHA=surface.alpha,
        NODES=_lobe_nodes(stack, surface),
        FACET_ENERGY=facet_energy,
        BRUSHED=brushed,
        ENERGY=energy,
        ALPHA=alpha,
        WIDTHS=lobe.widths,
        CLOSURE_ENERGY=lobe.energy,
    )
    index = fill("index_artist.osl" if "reflectance" in element else "index_complex.osl")
    return text, BaseClosures((Closure("weight_base", lobe.closure, is_local=True),), common=(index,))


def _lobe_nodes(stack: Stack, surface: Surface) -> str:
    above = stack.layers[-1] if stack.layers else stack.base
    nodes = {f"node_{name}": values for name, values in zip(("u", "weight", "x", "y", "cell"), base.lobe_nodes())}
    sides = f"{surface.alpha}, {surface.alpha}"
    if stack.base.has(ANISOTROPY):
        sides = ", ".join(f"side_alpha({surface.alpha_x}, {surface.alpha_y}, {sign}cos_2phi_{BASE})" for sign in ("", "-"))
    given = f"@node_u@, @node_weight@, @node_x@, @node_y@, {sides}, {beckmann(stack.base)}, {beckmann(above)}"
    body = [f"lobe_node(lobe, {given}, eta, k, node_share, radius);"]
    if stack.layers:
        body.append("carry_node(lobe, below, node_share, radius, @node_cell@);")
    return lines_of(for_each(nodes, body, len(stack.layers)))
