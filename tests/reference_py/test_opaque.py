# SPDX-License-Identifier: GPL-3.0-or-later
"""Opaque layers: patches, exact ends, energy, both truths, files, conversions and what is refused."""

import numpy as np
import pytest
from support.stacks import coat, conductor, lambert, stack

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.exchange.principled import to_principled
from lamina.reference_py.lobes.methods import followed_by_nodes
from lamina.reference_py.material.coverage import MAX_CLEAR, MAX_COVERED, patches
from lamina.reference_py.material.place import Place
from lamina.reference_py.material.schema import SCHEMA_VERSION
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.optics.optical_stack import OpticalStack
from lamina.reference_py.registry import make_model

WO = spherical(np.radians([0.0, 45.0, 75.0]), 0.3)
WI = spherical(np.radians([20.0, 40.0, 60.0]), 2.0)
GOLD = conductor(0.2, 3.9, 0.2)
PAINT = {"kind": "lambert", "color": [0.1, 0.4, 0.6]}
RUST = {"kind": "oren_nayar", "color": [0.3, 0.1, 0.05], "sigma_deg": 30.0}
COAT = coat(0.4, tint=[0.9, 0.8, 0.5])


def test_n_opaque_layers_make_n_plus_one_patches_with_what_lies_above_each():
    whole = stack(COAT, {**PAINT, "coverage": 0.25}, coat(0.1), {**RUST, "coverage": 0.5}, base=GOLD)
    parts = patches(whole)
    assert [(p.layers, p.base) for p in parts] == [((0,), 1), ((0, 2), 3), ((0, 2), None)]
    assert [p.share for p in parts] == [0.25, 0.375, 0.375]
    assert [p.stack.base.kind for p in parts] == ["lambert", "oren_nayar", "conductor"]
    assert not any("coverage" in p.stack.base for p in parts)


def test_places_of_an_opaque_layer_are_the_bases_in_its_patch():
    above, below = patches(stack(COAT, {**PAINT, "coverage": 0.5}, coat(0.1), base=GOLD))
    color, roughness = Place(1, "color"), Place(None, "roughness")
    assert above.place(color) == Place(None, "color") and below.place(color) is None
    assert above.place(roughness) is None and below.place(roughness) == roughness
    assert below.place(Place(2, "ior")) == Place(1, "ior")
    # stock nodes follow what the bake of each patch follows
    assert followed_by_nodes(stack(COAT, {**PAINT, "coverage": 0.5}, base=GOLD), "auto", (color, roughness)) == (color, roughness)
    assert followed_by_nodes(stack({**PAINT, "coverage": 0.5}, base=RUST), "auto", (Place(None, "color"),)) == (Place(None, "color"),)


@pytest.mark.parametrize("model", ["adding", "position_free", "weidlich_wilkie", "schlick"])
def test_models_are_exact_at_the_ends_and_linear_between(model):
    options = {"walks": 4096} if model == "position_free" else {}

    def f(coverage):
        return make_model(model, stack(COAT, {**PAINT, "coverage": coverage}, base=GOLD), **options).f(WO, WI)

    there, gone = (make_model(model, stack(COAT, base=base), **options).f(WO, WI) for base in (PAINT, GOLD))
    assert np.array_equal(f(1.0), there) and np.array_equal(f(0.0), gone)
    assert f(0.3) == pytest.approx(0.3 * there + 0.7 * gone, rel=1e-12)
    assert np.abs(there - gone).max() > 0.01


def test_truths_agree_on_opaque_layers():
    whole = stack(COAT, {**RUST, "coverage": 0.4}, coat(0.3, ior=1.7), {**PAINT, "coverage": 0.6}, base=GOLD)
    albedo, stderr = make_model("position_free", whole, walks=60000).albedo_stderr(WO)
    assert np.all(np.abs(make_model("adding", whole).albedo(WO) - albedo) < np.maximum(4.0 * stderr, 0.005))


@pytest.mark.parametrize("coverage", [0.0, 0.35, 1.0])
def test_white_stays_white(coverage):
    white = {"kind": "lambert", "color": [1.0, 1.0, 1.0]}
    whole = stack(coat(0.5), {**white, "coverage": coverage}, coat(0.3, ior=1.8), base=white)
    assert make_model("adding", whole).albedo(WO) == pytest.approx(1.0, abs=0.002)


def test_without_coverage_what_is_below_does_not_matter():
    hidden = make_model("adding", stack(COAT, PAINT, coat(0.1), base=GOLD)).albedo(WO)
    # products of matrices round by where they lie in memory: 2e-16 in some processes
    np.testing.assert_allclose(hidden, make_model("adding", stack(COAT, base=PAINT)).albedo(WO), rtol=1e-14)


def test_lowest_layer_is_the_base_where_there_is_none():
    for given in (PAINT, {**PAINT, "coverage": 1.0}):
        made = Stack.from_dict({"layers": [COAT, given]})
        assert made == stack(COAT, base=PAINT) and Stack.from_json(made.to_json()) == made


def test_round_trip_and_older_files():
    whole = stack({**GOLD, "coverage": 0.4, "film_thickness": 300.0, "film_ior": 1.4}, {**RUST, "name": "Rust"}, base=lambert(0.5))
    assert Stack.from_json(whole.to_json()) == whole
    assert whole.to_dict()["schema_version"] == SCHEMA_VERSION
    older = {"schema_version": SCHEMA_VERSION - 1, "layers": [COAT], "base": {**PAINT, "coverage": 0.5}}
    assert Stack.from_dict(older).base == stack(base=PAINT).base.__class__("lambert", stack(base=PAINT).base.values, {"coverage": 0.5})


FEW = [{**PAINT, "coverage": 0.5}] * MAX_COVERED


@pytest.mark.parametrize("data, words", [
    ({"schema_version": SCHEMA_VERSION + 1, "base": PAINT}, f"{SCHEMA_VERSION + 1} is newer than this Lamina"),
    ({"layers": [COAT, {**PAINT, "coverage": 0.9}]}, "no 'base', and the lowest layer, lambert, covers 0.9 of the surface; choose one of"),
    ({"layers": [COAT]}, "no 'base', and the lowest layer, dielectric, is clear; choose one of"),
    ({"layers": []}, "the stack is empty, it has no 'base'; choose one of"),
    ({"layers": [{**PAINT, "coverage": float("nan")}], "base": GOLD}, "layer 0: coverage is nan; choose 0 to 1"),
    ({"layers": [{"kind": "paint"}], "base": GOLD}, "unknown layer kind 'paint'; choose dielectric, lambert, oren_nayar, conductor"),
    ({"layers": [*FEW, FEW[0]], "base": GOLD}, "9 layers have a coverage .*; choose at most 8"),
    ({"layers": [{**COAT, "coverage": 0.5}] * (MAX_CLEAR + 1), "base": GOLD}, "4 clear layers have a coverage .*; choose at most 3"),
])  # fmt: skip
def test_bad_input_gives_one_line(data, words):
    with pytest.raises(LaminaError, match=words) as raised:
        patches(Stack.from_dict(data))
    assert "\n" not in str(raised.value)


def test_a_film_on_paint_is_kept_and_named():
    assert stack({**PAINT, "film_thickness": 200.0}, base=GOLD).unknown_keys() == ["layer 0: unknown key 'film_thickness' is kept and has no effect"]


def test_optics_of_a_whole_stack_are_refused():
    with pytest.raises(LaminaError, match="layer 1 is an opaque lambert: such a stack is several patches"):
        OpticalStack.of(stack(COAT, PAINT, base=GOLD))


@pytest.mark.parametrize("coverage, owner, metallic", [(0.3, -1, 1.0), (0.7, 1, 0.0)])
def test_conversion_takes_the_larger_part_as_base_and_keeps_the_mean_albedo(coverage, owner, metallic):
    converted = to_principled(stack(COAT, {**PAINT, "coverage": coverage}, base=GOLD))
    assert converted.owners["base"] == owner and converted.values.get("Metallic", 0.0) == metallic
    assert np.abs(converted.report.match.mean_error).max() < 1e-3
    assert any("layer 1 coverage" == loss.parameter for loss in converted.report.losses)
