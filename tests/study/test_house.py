# SPDX-License-Identifier: GPL-3.0-or-later
"""How the code hangs together, as `make house` counts it: the rules on small examples, and what has to hold of this tree."""

import ast
import re

import pytest

from lamina.study.house import (
    KINDS,
    QUESTIONS,
    ROOT,
    answers,
    asks_for_kinds,
    asks_how_it_was_made,
    compares_arrays,
    in_circles,
    shared_names,
    without_docstring,
)

# Names of files that stand in several folders, and mean the same there.
SAME = {
    "cache.py": "bakes that are kept, and the command that prints and clears them",
    "conversion.py": "conversions, and Blender's side of them",
    "double_grazing.py": "what is measured, and its chart",
    "fitting.py": "a fit, and the job beside the window that makes one",
    "hand_over.py": "what other programs find in a material, and the nodes that hold it",
    "live_values.py": "values that a shader follows, and their chart",
    "masks.py": "masks, and the nodes that draw them",
    "merl.py": "a format's reader and writer",
    "mitsuba.py": "what is written for Mitsuba, and its chart",
    "pools.py": "closures that patches share, and their chart",
    "principled.py": "conversion to a Principled node, and its command",
    "rgl.py": "a format's reader and writer",
    "scattering.py": "media that scatter, and their chart",
    "spectral.py": "stacks of spectra, their chart, and what RGB gets wrong of them",
    "tensor_file.py": "a format's reader and writer",
    "thumbnails.py": "presets' pictures, and what renders them",
    "tint_spectrum.py": "a tint as a spectrum, and its chart",
    "truth.py": "the truth at pairs of directions",
}


def test_nodes_of_a_circle_are_found():
    graph = {"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}, "e": set()}
    assert in_circles(graph) == {"b", "c"}


@pytest.mark.parametrize("text, asks", [
    ("if isinstance(lobes, LiveLobes): pass", True), ("x = holds_values(name)", True), ("y = method == 'baked'", True),
    ("from lamina.reference_py.lobes.methods import holds_values", False), ("if isinstance(x, dict): pass", False), ("live = 3", False),
])  # fmt: skip
def test_what_asks_how_a_lobe_set_was_made(text, asks):
    assert asks_how_it_was_made(ast.parse(text)) is asks


def test_comparisons_of_kinds_are_counted(tmp_path):
    (tmp_path / "addon").mkdir()
    (tmp_path / "addon" / "a.py").write_text("if kind == 'lambert' or kind in ('ggx', 'x'): pass\nif name == 'other': pass\n")
    assert asks_for_kinds(tmp_path).total() == 2 and "lambert" in KINDS


def test_files_of_one_name_mean_the_same():
    found = shared_names(ROOT)
    assert found.keys() == SAME.keys(), {name: found.get(name) for name in found.keys() ^ SAME.keys()}


@pytest.mark.parametrize("question", QUESTIONS)
def test_a_newcomer_finds_it_by_names_of_files(question):
    found = answers(ROOT, QUESTIONS[question])
    assert 1 <= len(found) <= 6 and all(re.search(QUESTIONS[question], path) for path in found)


def test_every_public_name_of_the_reference_says_what_it_is():
    assert without_docstring(ROOT) == []


def test_dataclasses_of_arrays_are_not_compared(tmp_path):
    assert compares_arrays(ROOT) == []
    (tmp_path / "addon").mkdir()
    (tmp_path / "addon" / "a.py").write_text("@dataclass(frozen=True)\nclass A:\n    x: np.ndarray | None\n@dataclass(frozen=True)\nclass B:\n    x: float\n")
    assert compares_arrays(tmp_path) == ["addon/a.py:2 A"]
