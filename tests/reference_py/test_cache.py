# SPDX-License-Identifier: GPL-3.0-or-later
"""What was computed is kept by content, in memory and in files; nothing stale, broken or of another version is used."""

import json
import os
import time
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest
from support.stacks import coat, conductor, lambert, stack

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes import cache
from lamina.reference_py.lobes.analytic import AnalyticLobes
from lamina.reference_py.lobes.cache import cached, get, stack_key
from lamina.reference_py.lobes.methods import auto, is_cached, key_of, make_lobe_set, packed, put
from lamina.reference_py.lobes.truth import truth_of
from lamina.reference_py.lobes.view_table import KNOTS, DiffuseTable, GlossyTable, TableLobes
from lamina.reference_py.material.place import Place

COATED = stack(coat(0.3, tint=[0.9, 0.5, 0.2], thickness=0.7), coat(0.1, ior=1.7), base=lambert(0.5))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty memory that is kept in a folder."""
    monkeypatch.setattr(cache, "_memory", {})
    cache.keep_in(tmp_path / "bakes", complaint)
    yield tmp_path / "bakes"
    cache.keep_in(None)


def complaint(text):
    raise AssertionError(text)


class Counted:
    """Remembers numbers by name, and counts how often one is made."""

    def __init__(self):
        self.made = []

    def __call__(self, key, value=1.5):
        return cached(key, lambda: self.made.append(key) or value, lambda number: {"number": number}, lambda data: data["number"])


def forget(monkeypatch):
    """As a new process would begin."""
    monkeypatch.setattr(cache, "_memory", {})


def test_what_is_known_is_not_made_again(folder, monkeypatch):
    number = Counted()
    assert [number("a"), number("a"), number("b", 2.5), number("a")] == [1.5, 1.5, 2.5, 1.5]
    assert number.made == ["a", "b"]
    forget(monkeypatch)
    assert (number("a", 9.0), number("b", 9.0)) == (1.5, 2.5) and number.made == ["a", "b"]
    assert get("c", lambda data: data["number"]) is None


def test_without_a_folder_it_lasts_as_long_as_the_process(monkeypatch):
    forget(monkeypatch)
    number = Counted()
    assert (number("a"), number("a", 9.0)) == (1.5, 1.5)
    forget(monkeypatch)
    assert number("a", 9.0) == 9.0


def test_what_another_version_computed_is_not_used(folder, monkeypatch):
    number = Counted()
    number("a")
    forget(monkeypatch)
    monkeypatch.setattr(cache, "_code", lambda: "another text")
    assert number("a", 2.0) == 2.0 and len(list(folder.glob("*.json"))) == 2


@pytest.mark.parametrize("text", ["", '{"numb', "[1, 2]", '{"other": 1}', "null", "\xff\xfe"])
def test_a_broken_file_is_made_anew(folder, monkeypatch, text):
    number = Counted()
    number("a")
    (file,) = folder.glob("*.json")
    file.write_bytes(text.encode("latin-1"))
    forget(monkeypatch)
    assert get("a", lambda data: data["number"]) is None
    assert number("a", 2.0) == 2.0 and json.loads(file.read_text()) == {"number": 2.0}


def test_the_oldest_go_first(folder, monkeypatch):
    monkeypatch.setattr(cache, "_FILES", 3)
    number = Counted()
    for date, key in enumerate("abcde"):
        number(key)
        newest = max(folder.glob("*.json"), key=lambda file: file.stat().st_mtime_ns)
        os.utime(newest, (1e9 + date, 1e9 + date))
    forget(monkeypatch)
    assert [key for key in "abcde" if get(key, lambda data: data["number"]) is not None] == ["c", "d", "e"]


def test_memory_has_an_end(monkeypatch):
    forget(monkeypatch)
    monkeypatch.setattr(cache, "_LIMIT", 3)
    number = Counted()
    for key in "abcd":
        number(key)
    assert [key for key in "abcd" if get(key, float) is not None] == ["b", "c", "d"]


def with_layer(values, which=0):
    layers = list(COATED.layers)
    layers[which] = layers[which].with_values(**values)
    return replace(COATED, layers=tuple(layers))


@pytest.mark.parametrize("same", [
    replace(COATED, name="another"),
    replace(COATED, layers=(replace(COATED.layers[0], unknown=MappingProxyType({"note": 1})), COATED.layers[1])),
    with_layer({"ior": 1.5 + 1e-7}),
    with_layer({"tint": (0.9 + 1e-8, 0.5, 0.2)}),
], ids=["name", "unknown key", "float32", "float32 color"])  # fmt: skip
def test_what_does_not_change_the_light_is_the_same_content(same):
    assert stack_key(same) == stack_key(COATED)


@pytest.mark.parametrize("other", [
    with_layer({"ior": 1.501}),
    with_layer({"tint": (0.9, 0.5, 0.201)}),
    with_layer({"thickness": 0.701}),
    with_layer({"distribution": "beckmann"}),
    with_layer({"roughness": 0.5}, 1),
    replace(COATED, layers=COATED.layers[::-1]),
    replace(COATED, layers=COATED.layers[:1]),
    replace(COATED, base=stack(base=conductor(0.2, 3.9, 0.2)).base),
    replace(COATED, base=stack(base={"kind": "oren_nayar", "color": [0.5] * 3, "sigma_deg": 0.0}).base),
], ids=["ior", "one channel", "thickness", "distribution", "second layer", "order", "count", "base", "kind of base"])  # fmt: skip
def test_what_changes_the_light_is_another_content(other):
    assert stack_key(other) != stack_key(COATED)


def test_of_live_values_only_that_they_are_live_counts():
    live = (Place(0, "thickness"),)
    assert stack_key(with_layer({"thickness": 3.0}), live) == stack_key(COATED, live) != stack_key(COATED)
    assert stack_key(COATED, (Place(1, "thickness"),)) != stack_key(COATED, live)
    assert stack_key(with_layer({"ior": 1.7}), live) != stack_key(COATED, live)
    # what every shader reads live needs no name
    half, most = (stack(coat(0.3, coverage=share), base=lambert(0.5)) for share in (0.5, 0.9))
    assert stack_key(half) == stack_key(most) != stack_key(stack(coat(0.3), base=lambert(0.5)))


def a_choice(made):
    """A choice of a bake whose tables are easily told apart."""
    ramp = np.linspace(0.1, 0.7, KNOTS)[:, None] * np.array([1.0, 0.5, 0.25])
    lobe_set = TableLobes((GlossyTable("beckmann", ramp, 0.5 * ramp), DiffuseTable(1.0 - ramp)))
    tried = (auto.Candidate("analytic", 2, 3.0, 0.001, 0.002, 0.2), auto.Candidate("baked, 1 glossy", 2, 1.3, 0.011, 0.012, 0.3))

    def choose(stack, truth, options):
        made.append(options)
        return auto.Choice(tried[1], lobe_set, tried, "a reason", tried[0])

    return choose


def test_a_choice_is_the_same_in_the_next_process(folder, monkeypatch):
    made = []
    monkeypatch.setattr(auto, "choose", a_choice(made))
    assert not is_cached(COATED, "auto")
    first = make_lobe_set(COATED, "auto")
    assert is_cached(COATED, "auto") and not is_cached(with_layer({"ior": 1.7}), "auto")
    forget(monkeypatch)
    again = make_lobe_set(replace(COATED, name="another"), "auto")
    assert len(made) == 1
    assert (again.choice.chosen, again.choice.tried, again.reason) == (first.choice.chosen, first.choice.tried, first.reason)
    assert first.reason == "baked, 1 glossy, error 1.2 %, cost 1.3x: a reason"
    cos_o = np.linspace(0.0, 1.0, 7)
    for lobe, other in zip(first.lobes(cos_o), again.lobes(cos_o), strict=True):
        assert type(lobe) is type(other) and np.array_equal(lobe.weight, other.weight)
    assert (again.lobes(cos_o)[0].distribution, again.lobe_count) == ("beckmann", 2)
    # another tolerance, or other live values, is another choice
    make_lobe_set(COATED, "auto", tolerance=0.1)
    make_lobe_set(COATED, "auto", live=(Place(0, "thickness"),))
    assert len(made) == 3


def test_a_chosen_live_method_is_made_of_the_stack_that_asks(folder, monkeypatch):
    """Values that are live differ between stacks of one content; the lobe set must have its own stack's."""
    candidate = auto.Candidate("analytic", 2, 3.0, 0.001, 0.002, 0.2)
    monkeypatch.setattr(auto, "choose", lambda stack, *arguments: auto.Choice(candidate, AnalyticLobes(stack), (candidate,), "so", candidate))
    live = (Place(0, "thickness"),)
    thin, thick = (make_lobe_set(one, "auto", live=live) for one in (COATED, with_layer({"thickness": 4.0})))
    assert thick.lobe_set.stack.layers[0]["thickness"] == 4.0 and thin.lobe_set.stack.layers[0]["thickness"] == 0.7
    forget(monkeypatch)
    assert isinstance(make_lobe_set(COATED, "auto", live=live).lobe_set, AnalyticLobes)


def test_what_another_process_made_is_taken_over(folder, monkeypatch):
    made = []
    monkeypatch.setattr(auto, "choose", a_choice(made))
    data = json.loads(json.dumps(packed(COATED, "auto")))
    forget(monkeypatch)
    cache.keep_in(None)
    put(key_of(COATED, "auto"), COATED, "auto", data)
    assert make_lobe_set(COATED, "auto").reason == "baked, 1 glossy, error 1.2 %, cost 1.3x: a reason" and len(made) == 1


def test_keys_tell_methods_lobes_and_tolerances_apart():
    keys = [
        key_of(COATED, "auto"),
        key_of(COATED, "auto", tolerance=0.05),
        key_of(COATED, "auto", glossy=2),
        key_of(COATED, "baked"),
        key_of(COATED, "baked", glossy=3),
        key_of(COATED, "baked", live=(Place(0, "thickness"),)),
    ]
    assert len(set(keys)) == len(keys)


@pytest.mark.parametrize(
    "layer, words",
    [
        ({"coverage": 0.5}, "a stack with coverage or opaque layers has one truth for each of its patches"),
        ({"anisotropy": 0.5}, "knows no anisotropy, which layer 1 has"),
    ],
)
def test_features_that_the_truth_does_not_know_are_refused(layer, words):
    with pytest.raises(LaminaError, match=words):
        truth_of(stack(coat(0.1), coat(0.3, **layer), base=lambert(0.5)))


def test_a_folder_is_bounded_by_bytes_and_what_was_used_last_stays(folder, monkeypatch):
    cache.cached("first", lambda: 1, lambda v: {"v": v, "fill": "x" * 1000}, lambda d: d["v"])
    monkeypatch.setattr(cache, "_BYTES", 2500)
    for age, key in ((3, "second"), (2, "third")):
        cache.cached(key, lambda: 1, lambda v: {"v": v, "fill": "x" * 1000}, lambda d: d["v"])
        os.utime(cache._file(key), (time.time() - age * 86400,) * 2)
        os.utime(cache._file("first"), (time.time() - 9 * 86400,) * 2)
        cache._memory.clear()
        assert cache.get("first", lambda d: d["v"]) == 1  # a hit makes it young
    assert {key for key in ("first", "second", "third") if cache._file(key).exists()} == {"first", "third"}
    held = cache.usage(cache._folder)
    assert (held.files, held.hits) == (2, 2) and held.size > 2000 and held.newest_days < 0.1 and 1.9 < held.oldest_days < 2.1


def test_what_was_not_used_for_days_is_cleaned(folder):
    for age, key in ((0, "young"), (8, "old")):
        cache.cached(key, lambda: 1, lambda v: {"v": v}, lambda d: d["v"])
        os.utime(cache._file(key), (time.time() - age * 86400,) * 2)
    assert cache.clean(cache._folder, 9).files == 0 and cache.clean(cache._folder, 7).files == 1
    assert cache._file("young").exists() and not cache._file("old").exists()
    assert cache.clean(cache._folder).files == 1 and not list(cache._folder.iterdir())
