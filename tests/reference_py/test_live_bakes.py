# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes over live parameters against the truth of values that no knot has, and what cannot be baked."""

from dataclasses import replace

import numpy as np
import pytest
from support.coats import CLAY, GLAZE, METAL, MILK, TWO_COATS, VARNISH, WOOD

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes import cache
from lamina.reference_py.lobes.baked.lobe_order import in_one_order
from lamina.reference_py.lobes.closure import lobe_energy
from lamina.reference_py.lobes.error_estimate import ErrorEstimator
from lamina.reference_py.lobes.live_grid import LiveLobes
from lamina.reference_py.lobes.methods import AnalyticLobes, key_of, make_lobe_set
from lamina.reference_py.lobes.tabulate import stock_lobes
from lamina.reference_py.lobes.truth import truth_of
from lamina.reference_py.lobes.view_table import KNOTS, DiffuseTable, GlossyTable, TableLobes, knot_cosines
from lamina.reference_py.material import presets
from lamina.reference_py.material.place import Place
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.frame import spherical

VIEWS_DEG = np.array([3.0, 25.0, 42.0, 61.0, 73.0, 80.0])
# Measured: 1.4 %, and 8.4 % where widths go on below the first knot, at roughness .15.
ALBEDO_TOLERANCE, SHAPE_TOLERANCE = 0.02, 0.09


def with_layer(stack: Stack, **values) -> Stack:
    return replace(stack, layers=(stack.layers[0].with_values(**values), *stack.layers[1:]))


@pytest.mark.parametrize("name, parameter, values", [("tinted_glaze", "thickness", (0.0, 0.3, 2.5)), ("frosted_paint", "roughness", (0.15, 0.45, 0.95))])
def test_between_knots_a_live_value_is_as_right_as_a_constant(name, parameter, values):
    stack = presets.load(name)
    baked = make_lobe_set(stack, "baked", live=(Place(0, parameter),)).lobe_set
    assert isinstance(baked, LiveLobes)
    for value in values:
        here = with_layer(stack, **{parameter: value})
        errors = ErrorEstimator(here, truth_of(here), np.cos(np.radians(VIEWS_DEG))).errors(replace(baked, stack=here))
        print(f"{name} {parameter} {value}: albedo {100 * errors.albedo.max():.2f} %, shape {100 * errors.shape.max():.1f} %")
        assert np.max(errors.albedo) <= ALBEDO_TOLERANCE
        assert np.max(errors.shape) <= SHAPE_TOLERANCE


def test_energy_follows_the_thickness_to_black():
    stack = presets.load("tinted_glaze")
    baked = make_lobe_set(stack, "baked", live=(Place(0, "thickness"),)).lobe_set
    cos_o = np.cos(np.radians(VIEWS_DEG))
    thick = [sum(lobe_energy(lobe, cos_o) for lobe in replace(baked, stack=with_layer(stack, thickness=t)).lobes(cos_o)) for t in (0.5, 1.0, 2.0, 8.0)]
    assert all(np.all(b <= a * (1.0 + ALBEDO_TOLERANCE)) for a, b in zip(thick, thick[1:]))


def test_live_values_do_not_make_another_bake(monkeypatch):
    monkeypatch.setattr(cache, "_memory", {})
    stack, live = presets.load("tinted_glaze"), (Place(0, "thickness"),)
    assert key_of(stack, "baked", live=live) == key_of(with_layer(stack, thickness=3.0), "baked", live=live)
    assert key_of(stack, "baked", live=live) != key_of(with_layer(stack, ior=1.7), "baked", live=live)


RANGES = {"roughness": (0.05, 0.9), "thickness": (0.05, 3.0), "ior": (1.2, 2.2), "sigma_deg": (0.0, 60.0), "density": (0.05, 12.0)}
VALUES = 4


def drawn(rng, stack: Stack, live) -> Stack:
    """The stack with live values that a generator draws."""
    for place in live:
        stack = place.with_value(stack, float(rng.uniform(*RANGES[place.name])) if place.name in RANGES else tuple(rng.uniform(0.03, 0.97, 3)))
    return stack


@pytest.mark.slow
@pytest.mark.parametrize(
    "layers, base, live, albedo, shape",
    [
        ([VARNISH], WOOD, [(0, "tint")], 0.004, 1.2),
        ([VARNISH], WOOD, [(0, "tint"), (0, "thickness")], 0.004, 1.1),
        ([GLAZE], METAL, [(0, "tint")], 0.006, 1.1),
        ([VARNISH], METAL, [(None, "reflectance")], 0.005, 1.1),
        ([], METAL, [(None, "reflectance")], 0.003, 0.8),
        ([], METAL, [(None, "roughness")], 0.003, 0.8),
        ([], METAL, [(None, "roughness"), (None, "reflectance")], 0.003, 0.7),
        ([GLAZE], METAL, [(None, "edge_color")], 0.004, 1.1),
        ([GLAZE], CLAY, [(None, "sigma_deg")], 0.004, 1.1),
        ([VARNISH], CLAY, [(None, "color")], 0.006, 1.2),
        ([VARNISH], WOOD, [(0, "ior")], 0.004, 1.1),
        ([VARNISH], WOOD, [(0, "tint"), (None, "color")], 0.006, 1.1),
        ([GLAZE, VARNISH], METAL, [(1, "ior")], 0.005, 1.1),
        (TWO_COATS, WOOD, [(1, "ior")], 0.01, 1.1),
        ([MILK], METAL, [(0, "density")], 0.004, 1.1),
        ([MILK], METAL, [(0, "scatter_color")], 0.004, 1.2),
        ([MILK], WOOD, [(0, "density"), (0, "scatter_color")], 0.0085, 1.3),
        ([VARNISH], WOOD, [(0, "roughness"), (0, "tint"), (0, "ior")], 0.012, 1.35),
        ([VARNISH], WOOD, [(0, "roughness"), (0, "tint"), (0, "ior"), (None, "color")], 0.008, 1.55),
        ([GLAZE], METAL, [(None, "roughness"), (None, "reflectance"), (0, "thickness")], 0.013, 1.2),
    ],
)
def test_values_are_as_right_as_constants(layers, base, live, albedo, shape):
    """Albedo, worst view and channel, against the truth; the median of shapes' errors over that of bakes of each value alone, without
    ramps where the grid has none."""
    stack, places = Stack.from_dict({"layers": layers, "base": base}), tuple(Place(*pair) for pair in live)
    baked = make_lobe_set(stack, "baked", live=places).lobe_set
    assert set(places) <= set(baked.followed)
    rng, found = np.random.default_rng(17), []
    for _ in range(VALUES):
        here = drawn(rng, stack, places)
        estimator = ErrorEstimator(here, truth_of(here), np.cos(np.radians(VIEWS_DEG)))
        alone = make_lobe_set(here, "baked").lobe_set
        has_ramps = isinstance(baked, TableLobes) or baked.ramp is not None
        followed, own = (estimator.errors(lobes) for lobes in (baked.with_values_of(here), alone if has_ramps else stock_lobes(alone)))
        found.append((np.max(followed.albedo), np.median(followed.shape) / np.median(own.shape)))
    worst, ratio = np.max([a for a, _ in found]), np.median([r for _, r in found])
    print(f"{', '.join(map(str, places))}: albedo {100 * worst:.2f} %, shape {ratio:.2f} of bakes of each alone")
    assert worst <= albedo and ratio <= shape


def test_channels_are_followed_apart():
    """A red tint takes nothing from green: one channel's tint changes that channel's energy alone."""
    stack = Stack.from_dict({"layers": [VARNISH], "base": WOOD})
    baked = make_lobe_set(stack, "baked", live=(Place(0, "tint"),)).lobe_set
    cos_o = np.cos(np.radians(VIEWS_DEG))
    red, grey = (
        sum(lobe_energy(lobe, cos_o) for lobe in baked.with_values_of(Place(0, "tint").with_value(stack, tint)).lobes(cos_o))
        for tint in ((0.9, 0.1, 0.1), (0.9, 0.9, 0.9))
    )
    np.testing.assert_allclose(red[:, 0], grey[:, 0], rtol=2e-3)
    assert np.all(red[:, 1] < 0.7 * grey[:, 1])


@pytest.mark.parametrize("live", [(Place(0, "roughness"), Place(0, "thickness"), Place(0, "ior"), Place(None, "roughness"))])
def test_what_a_bake_cannot_follow_is_analytic_and_said(live):
    made = make_lobe_set(presets.load("metallic_car_paint"), "baked", live=live)
    assert isinstance(made.lobe_set, AnalyticLobes)
    assert "analytic, as a bake cannot follow the" in made.reason and live[0].name in made.reason


def test_a_live_value_of_no_layer_is_refused():
    with pytest.raises(LaminaError, match="live value: the roughness of layer 7 of a stack of 1 layers"):
        make_lobe_set(presets.load("tinted_glaze"), "baked", live=(Place(7, "roughness"),))


@pytest.mark.parametrize("edge_color", [(1.0, 1.0, 1.0), METAL["edge_color"]])
def test_lobes_of_a_bare_metal_do_not_change_places_along_the_view(edge_color):
    """Between knots too: where they do, a narrow lobe and a wide one are mixed there (up to 19 % too bright, roughness .05)."""
    stack = Stack.from_dict({"layers": [], "base": {**METAL, "edge_color": list(edge_color), "roughness": 0.3}})
    baked = make_lobe_set(stack, "baked", live=(Place(None, "roughness"),)).lobe_set
    knots = np.sort(knot_cosines())
    cos_o = np.concatenate([knots, 0.5 * (knots[1:] + knots[:-1])])
    cos_o = cos_o[cos_o > np.cos(np.radians(85.0))]
    for roughness in (0.05, 0.13, 0.3, 0.58):
        here = replace(stack, base=stack.base.with_values(roughness=roughness))
        energy, truth = (
            sum(lobe_energy(lobe, cos_o) for lobe in baked.with_values_of(here).lobes(cos_o)),
            truth_of(here).albedo(spherical(np.arccos(cos_o), 0.0)),
        )
        error = np.max(np.abs(energy / truth - 1.0))
        print(f"roughness {roughness}: {100 * error:.1f} %")
        assert error < 0.015


def test_below_the_first_knot_lobes_get_narrow_no_faster_than_the_surface():
    """Where they went on as they began some were mirrors at a roughness of .1 (shapes 80 % off at the worst view, and more)."""
    stack = Stack.from_dict({"layers": [], "base": {**METAL, "edge_color": [1.0, 1.0, 1.0], "roughness": 0.3}})
    baked = make_lobe_set(stack, "baked", live=(Place(None, "roughness"), Place(None, "reflectance"))).lobe_set
    (axis,) = (axis for axis in baked.axes if axis.live[0].name == "roughness")
    number, knots = baked.axes.index(axis), axis.knots.knots
    for lobe in baked.grid:
        if lobe.shape is None:
            continue
        root = np.moveaxis(lobe.shape[..., :2], number, 0)
        for i in range(axis.before):
            assert np.all(root[i] >= root[axis.before] * knots[i] / knots[axis.before] - 1e-3)


@pytest.mark.parametrize("changed", [slice(3, 7), slice(0, 1), slice(5, None)])
def test_lobes_that_change_places_at_some_views_are_put_in_order(changed):
    def table(alpha, weight):
        return GlossyTable("ggx", np.full((KNOTS, 3), weight), np.tile([alpha, alpha, 0.0], (KNOTS, 1)))

    nodes, mixed = {}, {}
    for i, wide in enumerate((0.2, 0.5)):
        nodes[(i,)] = TableLobes((table(0.05, 0.7), DiffuseTable(np.ones((KNOTS, 3))), table(wide, 0.2)))
        narrow, diffuse, broad = nodes[(i,)].tables
        of = {name: [getattr(lobe, name).copy() for lobe in (narrow, broad)] for name in ("shape", "weight")}
        for a, b in of.values():
            a[changed], b[changed] = b[changed].copy(), a[changed].copy()
        first, last = (replace(lobe, shape=shape, weight=weight) for lobe, shape, weight in zip((narrow, broad), of["shape"], of["weight"]))
        mixed[(i,)] = TableLobes((first, diffuse, last))
    widths = [{round(float(lobe.shape[0, 0]), 6) for lobe in found.tables if isinstance(lobe, GlossyTable)} for found in in_one_order(mixed).values()]
    assert widths == [{0.05, 0.2}, {0.05, 0.5}]
    for found in in_one_order(mixed).values():
        for lobe in (found.tables[0], found.tables[2]):
            assert np.ptp(lobe.shape[:, 0]) == 0.0 and np.ptp(lobe.weight) == 0.0
