# SPDX-License-Identifier: GPL-3.0-or-later
"""Masks in stacks: kept through JSON, validated in one line, and nothing to the models."""

import pytest

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes.cache import stack_key
from lamina.reference_py.material import presets, ready_layers
from lamina.reference_py.material.coverage import patches
from lamina.reference_py.material.masks import GENERATORS
from lamina.reference_py.material.stack import Stack


def masked(masks) -> Stack:
    layer = {"kind": "oren_nayar", "coverage": 0.3, "masks": masks}
    return Stack.from_dict({"layers": [layer], "base": {"kind": "conductor", "roughness": 0.2}})


def test_json_keeps_masks_and_gives_what_is_missing_its_default():
    stack = masked({"coverage": {"generator": "edges", "amount": 0.2}})
    again = Stack.from_json(stack.to_json())
    assert again == stack and not again.unknown_keys()
    edges = GENERATORS["edges"]
    assert dict(again.layers[0].masks["coverage"].values) == {p.name: p.default for p in edges.parameters} | {"amount": 0.2}


def test_models_know_the_value_alone():
    with_mask, without = masked({"coverage": {"generator": "drips"}}), masked({})
    assert stack_key(with_mask) == stack_key(without)
    assert [p.share for p in patches(with_mask)] == [0.3, 0.7]
    assert not patches(with_mask)[0].stack.base.masks


@pytest.mark.parametrize(
    "masks, words",
    [
        ([], "masks are a JSON object"),
        ({"color": {"generator": "edges"}}, "'color' takes no mask; choose coverage"),
        ({"roughness": {"generator": "edges"}}, "'roughness' takes no mask"),
        ({"coverage": "edges"}, "must be a JSON object with a 'generator'"),
        ({"coverage": {}}, "unknown generator None; choose patches, edges"),
        ({"coverage": {"generator": "edges", "lenght": 3}}, "unknown key 'lenght'; choose amount"),
        ({"coverage": {"generator": "edges", "amount": -0.1}}, "amount is -0.1; choose 0 to 1"),
        ({"coverage": {"generator": "edges", "scale": 0}}, "scale is 0; choose 0.01 to 1000"),
        ({"coverage": {"generator": "edges", "seed": float("nan")}}, "seed is nan"),
    ],
)
def test_bad_masks_get_one_line(masks, words):
    with pytest.raises(LaminaError) as error:
        masked(masks)
    assert words in str(error.value) and "layer 0" in str(error.value) and "\n" not in str(error.value)


def test_what_is_called_worn_brings_a_mask():
    for name in ("chipped_painted_steel", "rusted_painted_steel", "dusty_piano", "worn_varnish", "fingerprinted_chrome"):
        stack = presets.load(name)
        assert any(part.masks for part in (*stack.layers, stack.base)), name
    for name in ("bare_steel", "rust", "dust", "moss", "mould", "chalk", "dirt", "rust_streaks", "fingerprints", "worn_varnish"):
        assert any(layer.masks for layer in ready_layers.load(name)[2]), name
