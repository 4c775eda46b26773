# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tier `analytic` writes for a stack: every value comes in through a parameter, tables are an array parameter.

Of a stack's features, an anisotropic surface has the energy of the view's azimuth (reference_py/lobes/analytic/brushed.py); a layer with
a normal of its own has the energy of that normal's view.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ....reference_py.lobes.analytic import base
from ....reference_py.lobes.analytic.lobe_set import ALBEDO_NODES
from ....reference_py.material.schema import ANISOTROPY
from ....reference_py.material.stack import Base, Layer, Stack
from .analytic_layers import Tables, beam_of, for_each, has_loops, layers_lines, roughest, view_lines
from .block import Block, Closure
from .surface import BaseClosures, Surface, base_name, beckmann, diffuse_closures, is_metal, is_rough, metal_closure, surface_of, top_closure, top_function

NOTE = "Adding over the interfaces at every shading point."


def analytic_block(stack: Stack, owners: Sequence[str], stands_in: bool) -> Block:
    """The block of a stack whose shader parameters begin with `owners`, those of the layers and of the base; short where it only stands in."""
    surfaces = [surface_of(element, owner) for element, owner in zip((*stack.layers, stack.base), owners)]
    energies, loops = Tables.of(stack), has_loops(stack, stands_in)
    body, closures = [], []
    if stack.layers:
        body += layers_lines(stack, owners[:-1], surfaces, energies, loops)
        top, seen = surfaces[0], "alpha_0"
        if stack.layers[0].has(ANISOTROPY):
            seen = "alpha_seen"
            body.append(f"float alpha_seen = seen_alpha({top.alpha_x}, {top.alpha_y}, cos_2phi_{owners[0]}, {top.view});")
        for view in dict.fromkeys((surfaces[1].view, surfaces[-1].view)):
            body += view_lines(stack, energies, loops, view, seen)
        weight = f"top_gain({energies.arguments(stack.layers[0]['distribution'])}, {top.view}, {seen}, n_1)"
        closures.append(Closure(weight, top_closure(top, stack.layers[0], owners[0])))
    if len(stack.layers) > 1:
        lines, closure = _deeper_interfaces(stack.layers[1], surfaces[1], owners[1], energies)
        body += lines
        closures.append(closure)
    lines, base_closures = _metal(stack, surfaces[-1], owners[-1], energies, loops) if is_metal(stack) else _diffuse(stack, surfaces[-1], owners[-1])
    return Block(
        functions=(*(name for surface in surfaces for name in surface.functions), *base_closures.functions, *_functions(stack)),
        arrays=energies.arrays,
        common=(*(text for surface in surfaces for text in surface.common), *_azimuths(stack, owners, surfaces), *base_closures.common),
        body=(*body, *lines),
        closures=(*closures, *base_closures.closures),
    )


def _functions(stack: Stack) -> list[str]:
    """The files that this structure calls."""
    names = []
    if any(element.has(ANISOTROPY) for element in (*stack.layers, stack.base)):
        names.append("anisotropic_energy.h")
    if stack.layers:
        names += [top_function(stack.layers[0]), "medium.h", "analytic_beam.h", "analytic_lobe.h"]
        if any(element.has(ANISOTROPY) for element in (*stack.layers[1:2], stack.base)):
            names.append("anisotropic_alpha.h")
        if is_rough(stack.base):
            names.append("oren_nayar_albedo.h")
    if is_metal(stack):
        names += ["analytic_tables.h", "analytic_metal.h"]
        if stack.base.has(ANISOTROPY):
            names.append("anisotropic_metal.h")
        if stack.layers:
            names.append("analytic_coated_metal.h")
    return names


def _azimuths(stack: Stack, owners: Sequence[str], surfaces: Sequence[Surface]) -> list[str]:
    elements = zip((*stack.layers, stack.base), owners, surfaces)
    return [
        f"float cos_2phi_{owner} = cos_twice_azimuth(I, {surface.normal}, {surface.tangent});"
        for element, owner, surface in elements
        if element.has(ANISOTROPY)
    ]


@dataclass(frozen=True)
class _Lobe:
    """What leaves an element below others: statements of its widths, its closure, and the directional albedo of that."""

    widths: tuple[str, ...]
    closure: str
    energy: str

    @classmethod
    def of(cls, element: Layer | Base, surface: Surface, owner: str, name: str, n: str | None, energies: Tables) -> "_Lobe":
        """The lobe of width `alpha_{name}` of an element below index n, or bare: along its axes as far as the width is its own."""
        alpha, distribution = f"alpha_{name}", element["distribution"]
        table = energies.arguments(distribution)
        if not element.has(ANISOTROPY):
            shaped = surface if n is None else replace(surface, alpha_x=alpha, alpha_y=f"break_isotropy({alpha})")
            return cls((), shaped.microfacet(distribution), f"closure_energy({table}, {surface.view}, {alpha})")
        statements = []
        if n is not None:
            own = {f"alpha_x_{name}": surface.alpha_x, f"alpha_y_{name}": surface.alpha_y}
            for lobe_alpha, width in own.items():
                value = f"anisotropic_alpha({alpha}, {surface.alpha}, {width} / max({surface.alpha}, 1e-12), {n}, {surface.view})"
                statements.append(f"float {lobe_alpha} = {value};")
            surface = replace(surface, **dict(zip(("alpha_x", "alpha_y"), own)))
        return cls(tuple(statements), surface.microfacet(distribution), _anisotropic_energy(table, surface.view, owner, surface))


def _anisotropic_energy(table: str, cosine: str, owner: str, surface: Surface) -> str:
    return f"anisotropic_energy({table}, {cosine}, cos_2phi_{owner}, {surface.alpha_x}, {surface.alpha_y})"


def _deeper_interfaces(layer: Layer, surface: Surface, owner: str, energies: Tables) -> tuple[list[str], Closure]:
    """All interfaces below the top as one lobe with the axes of the second, `layer`: statements and the closure."""
    lobe, beam = _Lobe.of(layer, surface, owner, "inner", "n_1", energies), beam_of(surface.view)
    lines = [
        f"float alpha_inner = lobe_alpha({beam}.spread / max(mean({beam}.inner), 1e-12), {surface.view});",
        *lobe.widths,
        f"color weight_inner = {beam}.inner / max({lobe.energy}, 1e-3);",
    ]
    return lines, Closure("weight_inner", lobe.closure, is_local=True)


def _diffuse(stack: Stack, surface: Surface, owner: str) -> tuple[list[str], BaseClosures]:
    """Statements for the weight of a diffuse base, and its closures."""
    closures, color, sigma = diffuse_closures(stack.base, surface, owner), f"{owner}Color", base_name(owner, "sigma")
    if not stack.layers:
        return [], closures
    beam = beam_of(surface.view)
    if not is_rough(stack.base):
        return [], closures.below(f"{beam}.transmitted * escaped / (1.0 - {color} * reflected)")
    terms = [f"{2.0 * w * u:.9g} * oren_nayar_albedo({u:.9g}, {color}, {sigma})" for u, w in zip(*base.gauss(ALBEDO_NODES))]
    lines = [
        f"color mean_albedo = {' + '.join(terms)};",
        f"color below_layers = oren_nayar_albedo(min(cosine({beam}.p, n_{len(stack.layers)}), 1.0), {color}, {sigma});",
        f"color bare = max(oren_nayar_albedo({surface.view}, {color}, {sigma}), color(1e-12));",
        f"color weight_base = {beam}.transmitted * below_layers * escaped / (1.0 - mean_albedo * reflected) / bare;",
    ]
    return lines, closures.below("weight_base")


def _metal(stack: Stack, surface: Surface, owner: str, energies: Tables, loops: bool) -> tuple[list[str], BaseClosures]:
    """The same of a metal base."""
    element, count = stack.base, len(stack.layers)
    table = energies.arguments(element["distribution"])
    if count:
        n, beam = f"n_{count}", beam_of(surface.view)
        arrives = f"{beam}.p, {beam}.variance"
        energy = f"{beam}.transmitted * metal_energy(lobe, facets, keep, {surface.alpha}, {roughest(count)}, reflected, escaped)"
        alpha = f"lobe_alpha(2.0 * {beam}.variance + pow(2.0 * {n} * lobe.c * {surface.alpha}, 2.0), {surface.view})"
    else:
        n, arrives, energy = "1.0", f"sqrt(1.0 - {surface.view} * {surface.view}), 0.0", "(lobe.once * keep + facets)"
        alpha = surface.alpha
    lobe = _Lobe.of(element, surface, owner, "base", n if count else None, energies)
    facet_energy, planar = f"closure_energy({table}, lobe.c, {surface.alpha})", []
    if element.has(ANISOTROPY):
        facet_energy = _anisotropic_energy(table, "lobe.c", owner, surface)
        planar = [f"facets = later_anisotropic_facets(facets, lobe, facet_energy, {surface.alpha_x}, {surface.alpha_y});"]
    lines = [
        f"color eta = {base_name(owner, 'eta')} / {n};",
        f"color k = {base_name(owner, 'k')} / {n};",
        "Lobe lobe;",
        "color node_share;",
        "float radius;",
        "float keep;",
        f"start_lobe(lobe, {arrives}, {n}, {surface.alpha});",
        *_lobe_nodes(stack, surface, owner, loops),
        f"float facet_energy = {facet_energy};",
        f"color facets = later_facets(lobe, facet_energy, {surface.alpha}, eta, k, keep);",
        *planar,
        f"float alpha_base = {alpha};",
        *lobe.widths,
        f"color weight_base = {energy} / max({lobe.energy}, 1e-3);",
    ]
    return lines, metal_closure(element, owner, Closure("weight_base", lobe.closure, is_local=True))


def _lobe_nodes(stack: Stack, surface: Surface, owner: str, loops: bool) -> list[str]:
    above = stack.layers[-1] if stack.layers else stack.base
    nodes = {f"node_{name}": values for name, values in zip(("u", "weight", "x", "y", "cell"), base.lobe_nodes())}
    sides = f"{surface.alpha}, {surface.alpha}"
    if stack.base.has(ANISOTROPY):
        sides = ", ".join([f"side_alpha({surface.alpha_x}, {surface.alpha_y}, {sign}cos_2phi_{owner})" for sign in ("", "-")])
    given = f"@node_u@, @node_weight@, @node_x@, @node_y@, {sides}, {beckmann(stack.base)}, {beckmann(above)}"
    body = [f"lobe_node(lobe, {given}, eta, k, node_share, radius);"]
    if stack.layers:
        body.append("carry_node(lobe, below, node_share, radius, @node_cell@);")
    return for_each(nodes, body, loops)
