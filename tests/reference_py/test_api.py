# SPDX-License-Identifier: GPL-3.0-or-later
"""`import lamina`: what it costs, its functions, pictures of stacks, and the cells of docs/research.md, which run here."""

import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import lamina
from lamina.reference_py import api
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.plots import side_view
from lamina.reference_py.plots.stack_picture import picture
from lamina.reference_py.registry import MODELS, make_model

PAGE = Path(lamina.__file__).parent / "docs" / "research.md"
STACK = Stack.from_dict({"layers": [{"kind": "dielectric", "roughness": 0.5, "tint": [0.5, 0.8, 1.0]}], "base": {"kind": "lambert"}})
VIEW = spherical(np.radians(30.0), 0.0)


def test_the_package_reads_nothing_until_it_is_asked():
    code = (
        "import sys, lamina\n"
        "before = [n for n in sys.modules if n.startswith('lamina.') or n == 'numpy']\n"
        "assert not before, before\n"
        "from lamina import reference_py\n"
        "assert 'lamina.reference_py.api' not in sys.modules and not hasattr(lamina, 'albdeo')\n"
        "assert {'load', 'albedo', 'f', 'sample'} < set(dir(lamina)) and 'lamina.reference_py.api' not in sys.modules\n"
        "lamina.load('glazed_mug')\n"
        "assert 'lamina.reference_py.api' in sys.modules and 'bpy' not in sys.modules and 'matplotlib' not in sys.modules\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_every_name_is_there():
    assert all(getattr(lamina, name) is not None for name in lamina._API) and list(lamina._API) == api.__all__
    assert set(lamina.models()) == set(MODELS) and lamina.models()["adding"] == ("surface", "nodes", "modes", "draft")
    assert lamina.names() == presets.names()


def test_functions_say_what_models_say():
    name = "weidlich_wilkie"
    model = make_model(name, STACK, masking="v_cavity")
    assert np.array_equal(lamina.albedo(STACK, theta=[[30.0]], model=name, masking="v_cavity"), model.albedo(VIEW[None, None]))
    wi = spherical(np.radians([20.0, 50.0]), np.radians([180.0, 90.0]))
    by_angle = lamina.f(STACK, (30.0, 0.0), [(20.0, 180.0), (50.0, 90.0)], model=name, masking="v_cavity")
    assert np.array_equal(by_angle, model.f(VIEW, wi)) and np.array_equal(by_angle, lamina.f(STACK, VIEW, wi, model=name, masking="v_cavity"))
    assert np.array_equal(lamina.albedo("glazed_mug", theta=0.0), lamina.model("glazed_mug").albedo(spherical(0.0, 0.0)))


@pytest.mark.parametrize("name, options", [("weidlich_wilkie_repaired", {}), ("closure_model", {"method": "analytic"}), ("adding", {"draft": 1})])
def test_samples_estimate_the_albedo(name, options):
    wi, valid, pdf, f = lamina.sample(STACK, (30.0, 0.0), n=20_000, rng=1, model=name, **options)
    values = np.where(valid[:, None], f * wi[:, 2:] / np.maximum(pdf, 1e-30)[:, None], 0.0)
    error = values.std(axis=0) / np.sqrt(len(values))
    assert np.all(np.abs(values.mean(axis=0) - lamina.albedo(STACK, theta=30.0, model=name, **options)) < 4.0 * error)
    assert lamina.sample(STACK, (30.0, 0.0), n=0, model=name, **options).wi.shape == (0, 3)


def test_samples_of_walks_estimate_the_albedo():
    """Few walks to each f are enough: they are right in the mean."""
    wi, valid, pdf, f = lamina.sample(STACK, (30.0, 0.0), n=2_000, rng=1, model="position_free", walks=8)
    values = np.where(valid[:, None], f * wi[:, 2:] / np.maximum(pdf, 1e-30)[:, None], 0.0)
    error = values.std(axis=0) / np.sqrt(len(values))
    exact = lamina.albedo(STACK, theta=30.0)
    assert np.all(error < 0.04 * exact) and np.all(np.abs(values.mean(axis=0) - exact) < 4.0 * error)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: lamina.sample(STACK, VIEW, model="schlick"), "model schlick has no samples; choose .*closure_model"),
        (lambda: lamina.sample(STACK, VIEW, model="phong"), "unknown model 'phong'"),
        (lambda: lamina.sample(STACK, VIEW, n=-1, model="weidlich_wilkie"), "n is -1; choose a whole number"),
        (lambda: lamina.albedo(STACK, theta="steep"), "theta is 'steep'; choose angles in degrees"),
        (lambda: lamina.f(STACK, VIEW, 2.0 * VIEW, model="schlick"), "wi has a direction of length 2"),
        (lambda: lamina.albedo("no_such_preset"), "unknown preset 'no_such_preset'"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(call, said):
    with pytest.raises(LaminaError, match=said) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_a_notebook_shows_layers_and_lobes():
    drawn = ElementTree.fromstring(lamina.load("glazed_mug")._repr_html_())
    words = " ".join(e.text or "" for e in drawn.iter() if e.tag.endswith("text"))
    assert "Glazed Mug" in words and "lobes" in words and "clear layer" in words and "ior 1.6" in words
    brushed = Stack.from_dict({"layers": [], "base": {"kind": "conductor", "metal": "silver", "anisotropy": 0.5}, "name": "<&>"})
    words = " ".join(e.text or "" for e in ElementTree.fromstring(brushed._repr_html_()).iter() if e.tag.endswith("text"))
    assert "no lobes: model adding knows no anisotropy" in words and "<&>" in words


def test_a_picture_has_colors_that_all_readers_know_and_words_that_fit():
    glaze = {"kind": "dielectric", "name": "a glaze of very many words, of which some are too many", "extinction": [1.0] * 3, "scatter_albedo": [0.9] * 3}
    drawn = picture(Stack.from_dict({"layers": [glaze], "base": {"kind": "lambert"}}), make_model("weidlich_wilkie", STACK))
    assert "hsl(" not in drawn and "too many" not in drawn and "a glaze of very many words" in drawn and ">red<" in drawn
    assert "cloudy layer" in picture(
        Stack.from_dict({"layers": [{**glaze, "name": "milk"}], "base": {"kind": "lambert"}}), make_model("weidlich_wilkie", STACK)
    )


@pytest.mark.parametrize("name", presets.names())
def test_every_preset_can_be_drawn(name):
    drawn = ElementTree.fromstring(picture(presets.load(name), make_model("weidlich_wilkie", STACK)))
    assert "nan" not in ElementTree.tostring(drawn, encoding="unicode")


def test_a_layer_has_the_color_that_it_leaves():
    thick = Stack.from_dict({"layers": [{"kind": "dielectric", "tint": [0.5, 1.0, 0.1], "thickness": 2.0}], "base": {"kind": "lambert"}})
    assert side_view.shown_color(thick.layers[0]) == pytest.approx([0.25, 1.0, 0.01]) and side_view.hex_color(np.array([0.0, 1.0, 2.0])) == "#00ffff"


def test_the_cells_of_the_page_for_researchers_run():
    cells = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    names: dict = {}
    for cell in cells:
        exec(compile(cell, PAGE.name, "exec"), names)
    assert len(cells) >= 8 and names["spectrum"].shape == (2, 16)
