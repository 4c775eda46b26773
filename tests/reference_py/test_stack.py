# SPDX-License-Identifier: GPL-3.0-or-later
"""Stacks: immutable, validated with one clear line, JSON round trips that lose nothing."""

import dataclasses
import json
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material import presets
from lamina.reference_py.material.json_input import MAX_FILE_BYTES
from lamina.reference_py.material.schema import SCHEMA, SCHEMA_VERSION, VECTOR
from lamina.reference_py.material.stack import Stack

LAMBERT = {"kind": "lambert"}


def values(parameter):
    """Valid values of a parameter of the schema."""
    if parameter.is_structural:
        return st.sampled_from(parameter.choices)
    number = st.floats(parameter.minimum, parameter.maximum, allow_subnormal=False)
    return number if parameter.type == "float" else st.tuples(number, number, number).map(list)


def elements(kinds):
    def of(kind):
        unused = {name for group in kind.alternatives[1:] for name in group}
        return st.fixed_dictionaries({"kind": st.just(kind.name)}, optional={p.name: values(p) for p in kind.parameters if p.name not in unused})

    return st.one_of([of(kind) for kind in kinds.values()])


STACKS = st.fixed_dictionaries(
    {"layers": st.lists(elements(SCHEMA.layers), max_size=5), "base": elements(SCHEMA.bases)},
    optional={"name": st.text(st.characters(codec="utf-8")), "studio_note": st.dictionaries(st.text("ab"), st.integers())},
)


@given(STACKS)
def test_json_round_trip_keeps_every_value_and_unknown_key(data):
    stack = Stack.from_dict(data)
    again = Stack.from_json(stack.to_json())
    assert again.to_dict() == stack.to_dict()
    written = again.to_dict()
    assert written["schema_version"] == SCHEMA_VERSION
    for given_layer, layer in zip(data["layers"], written["layers"]):
        assert given_layer.items() <= layer.items()
    if "studio_note" in data:
        assert written["studio_note"] == data["studio_note"]


@given(st.text() | st.binary().map(lambda b: b.decode("latin-1")))
def test_any_text_is_a_stack_or_one_line(text):
    try:
        Stack.from_json(text, "file.json")
    except LaminaError as error:
        assert str(error).startswith("file.json: ")


def test_missing_keys_take_the_schemas_defaults():
    stack = Stack.from_dict({"layers": [{"kind": "dielectric"}], "base": {"kind": "conductor"}})
    for parameter in SCHEMA.layers["dielectric"].parameters:
        assert stack.layers[0][parameter.name] == parameter.default
    assert stack.base["metal"] == SCHEMA.bases["conductor"].parameter("metal").default
    assert "eta" not in stack.base


def test_a_stack_cannot_be_changed():
    stack = presets.load("crayon_paint")
    with pytest.raises(dataclasses.FrozenInstanceError):
        stack.name = "other"
    with pytest.raises(TypeError):
        stack.layers[0].values["ior"] = 2.0


def test_a_text_that_looks_like_a_list_is_kept():
    stack = Stack.from_dict({"base": LAMBERT, "source": "see [ 1,\n 2, 3 ]"})
    assert Stack.from_json(stack.to_json()).source == stack.source


BAD = [
    ({}, ["empty", "'base'", "lambert, oren_nayar, conductor"]),
    ([], ["JSON object", "list"]),
    ({"base": {"kind": "wood"}}, ["base", "'wood'", "lambert, oren_nayar, conductor"]),
    ({"base": LAMBERT, "layers": [{"kind": "glass"}]}, ["layer 0", "'glass'", "dielectric"]),
    ({"base": LAMBERT, "layers": [{"kind": "dielectric", "ior": 0.5}]}, ["layer 0", "ior", "0.5", "1 to 4"]),
    ({"base": LAMBERT, "layers": [{"kind": "dielectric", "thickness": -1}]}, ["thickness", "-1", "0 to 1000"]),
    ({"base": LAMBERT, "layers": [{"kind": "dielectric", "roughness": float("nan")}]}, ["roughness", "nan", "0 to 1"]),
    ({"base": LAMBERT, "layers": [{"kind": "dielectric", "ior": "big"}]}, ["ior", "number", "'big'"]),
    ({"base": LAMBERT, "layers": [{"kind": "dielectric", "ior": True}]}, ["ior", "number", "True"]),
    ({"base": LAMBERT, "layers": [{"kind": "dielectric", "ior": 10**400}]}, ["ior", "1 to 4"]),
    ({"base": LAMBERT, "layers": [{"kind": "dielectric", "tint": [1, 2]}]}, ["tint", "three numbers"]),
    ({"base": LAMBERT, "layers": [{"kind": "dielectric", "distribution": "phong"}]}, ["'phong'", "ggx, beckmann"]),
    ({"base": LAMBERT, "layers": 3}, ["'layers'", "list", "int"]),
    ({"base": LAMBERT, "layers": [LAMBERT] * 65}, ["65 layers", "64"]),
    ({"base": LAMBERT, "name": 7}, ["name", "text", "7"]),
    ({"base": LAMBERT, "schema_version": 99}, ["schema_version 99", "newer", f"1 to {SCHEMA_VERSION}"]),
    ({"base": LAMBERT, "schema_version": "x"}, ["schema_version 'x'"]),
    ({"base": {"kind": "conductor", "metal": "mithril"}}, ["metal", "'mithril'", "copper", "silver"]),
    ({"base": {"kind": "conductor", "metal": "gold", "eta": [1, 1, 1]}}, ["metal", "eta", "exclude"]),
    ({"base": {"kind": "conductor", "eta": [1, 1, 1]}}, ["eta+k", "k is missing"]),
]


@pytest.mark.parametrize("data, words", BAD)
def test_bad_input_is_one_line_that_names_thing_value_and_choices(data, words):
    with pytest.raises(LaminaError) as caught:
        Stack.from_dict(data, "here")
    message = str(caught.value)
    assert message.startswith("here")
    assert "\n" not in message
    for word in words:
        assert word in message


@pytest.mark.parametrize(
    "text, word",
    [
        ('{"base": ', "line 1 column"),
        ('{"base": {"kind": "lambert", "color": [NaN, 0, 0]}}', "NaN"),
        ("[" * 100_000, "nested too deeply"),
        ('{"name": "\\ud800", "base": {"kind": "lambert"}}', "half a character"),
        ('{"x": 1' + "0" * 5000 + "}", "readable"),
    ],
)
def test_broken_json_is_one_line(text, word):
    with pytest.raises(LaminaError, match=word):
        Stack.from_json(text, "x.json")


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(LaminaError, match="No such file"):
        Stack.load(tmp_path / "none.json")
    with pytest.raises(LaminaError, match="cannot read"):
        Stack.load(tmp_path)
    (tmp_path / "latin.json").write_bytes(b"\xff\xfe{}")
    with pytest.raises(LaminaError, match="UTF-8"):
        Stack.load(tmp_path / "latin.json")
    (tmp_path / "big.json").write_text(" " * (MAX_FILE_BYTES + 1))
    with pytest.raises(LaminaError, match="too large"):
        Stack.load(tmp_path / "big.json")


def test_saving_is_whole_or_not_at_all(tmp_path, monkeypatch):
    stack = presets.load("metal_foil")
    path = tmp_path / "ünïcode name.json"
    stack.save(path)
    before = path.read_bytes()
    assert json.loads(before)["name"] == "Metal Foil"

    def full_disk(source, target):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full_disk)
    with pytest.raises(LaminaError, match="No space left"):
        presets.load("crayon_paint").save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(LaminaError, match="cannot write into folder"):
        stack.save(tmp_path / "missing" / "x.json")


def test_schema_is_consistent():
    for kind in (*SCHEMA.layers.values(), *SCHEMA.bases.values()):
        names = [p.name for p in kind.parameters]
        assert len(set(names)) == len(names)
        assert len({p.label for p in kind.parameters}) == len(names)
        for parameter in kind.parameters:
            assert parameter.help and not parameter.help.endswith(".")
            default = list(parameter.default) if parameter.type in ("color", VECTOR) else parameter.default
            assert parameter.check(default, "default") == parameter.default
