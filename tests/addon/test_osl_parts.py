# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of `osl/`: each compiles by itself and is used, and the way from a lobe set to a shader's text goes one way."""

import itertools
import re
import shutil
import sys
from dataclasses import replace

import numpy as np
import pytest

from lamina.addon.shader.osl import osl_files
from lamina.addon.shader.osl.generate import generate
from lamina.reference_py.lobes.axes import NumberAxis, Scale
from lamina.reference_py.lobes.baked.base_ramp import with_ramp
from lamina.reference_py.lobes.baked.make_grid import grid_of
from lamina.reference_py.lobes.live_grid import LogEnergy
from lamina.reference_py.lobes.lobe import DielectricCurve
from lamina.reference_py.lobes.made import Made
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.lobes.view_table import AZIMUTHS, KNOTS, DiffuseTable, GlossyTable, TableLobes
from lamina.reference_py.material.place import Place
from lamina.reference_py.material.stack import Stack

FILES = sorted(path.name for path in osl_files.PARTS.iterdir())
TRIVIAL = '#include "{}"\nshader trivial(output float Out = 0.0)\n{{\n    Out = 1.0;\n}}\n'

COAT = {"kind": "dielectric", "ior": 1.4, "roughness": 0.2, "tint": [0.9, 0.5, 0.3]}
ANISOTROPIC = {"anisotropy": 0.6, "rotation": 0.1}
FILM = {"film_thickness": 400.0, "film_ior": 1.7}
METAL = {"kind": "conductor"}
LAYERS = [[], [COAT], [COAT, COAT], [{**COAT, **FILM}, COAT], [{**COAT, **ANISOTROPIC}, {**COAT, **ANISOTROPIC, "normal": [0.1, 0.0, 1.0]}]]
BASES = [
    {"kind": "lambert"},
    {"kind": "oren_nayar"},
    METAL,
    {**METAL, **ANISOTROPIC},
    {"kind": "conductor", "reflectance": [0.9, 0.5, 0.3], "edge_color": [1.0, 1.0, 1.0]},
]


ONE = Stack.from_dict({"layers": [COAT], "base": {"kind": "lambert"}})


def tables(alpha: float) -> TableLobes:
    """Lobes as a bake may give them: a coat, a tilted and a round one below it, and a base."""
    weight = np.linspace(0.2, 0.4, KNOTS)[:, None] * np.ones(3)
    tilted = np.linspace(1.0, 1.2, KNOTS)[:, None] * np.array([alpha, 0.8 * alpha, 0.1])
    coat = GlossyTable("ggx", np.ones((KNOTS, 3)), np.full((KNOTS, 3), [alpha, alpha, 0.0]), DielectricCurve(1.4))
    round_lobe = np.linspace(1.0, 1.2, KNOTS)[:, None] * np.array([alpha, alpha, 0.0])
    return TableLobes((coat, GlossyTable("ggx", weight, tilted), GlossyTable("ggx", weight, round_lobe), DiffuseTable(weight)))


def baked():
    return Made("baked", ONE, tables(0.1))


def brushed():
    """Weights that turn with the tangent."""
    lobe, weight = tables(0.1).tables[1], np.full((len(AZIMUTHS), KNOTS, 3), 0.3)
    return Made(
        "baked",
        Stack.from_dict({"layers": [{**COAT, **ANISOTROPIC}], "base": {"kind": "lambert"}}),
        TableLobes((replace(lobe, weight=weight, frame=0.6, axis=0.6),)),
    )


def baked_live(over_color: bool = False):
    scale, energy = Scale(0.3, 0.6, 2), np.full((KNOTS, 3), 0.3)
    axis = NumberAxis((Place(0, "roughness"),), scale, scale, scale)
    energies = {"mirrors": LogEnergy((np.stack([energy, energy]),)), "fitted": LogEnergy((np.stack([energy, 0.5 * energy]),))}
    if over_color:
        energies |= {"through": energies["mirrors"], "back": energies["fitted"]}
    lobes = grid_of(ONE, (axis,), {(0,): tables(0.09), (1,): tables(0.36)}, energies, None)
    return Made("baked", ONE, with_ramp(lobes) if over_color else lobes)


def baked_metal():
    stack = Stack.from_dict({"base": {"kind": "conductor", "reflectance": [0.9, 0.5, 0.2], "edge_color": [0.8, 0.8, 0.8], "roughness": 0.4}})
    return make_lobe_set(stack, "baked", live=(Place(None, "reflectance"),))


def all_made():
    """One of each structure that writes something of its own."""
    for layers, base, tier in itertools.product(LAYERS, BASES, ("analytic", "weidlich_wilkie")):
        yield make_lobe_set(Stack.from_dict({"layers": layers, "base": base}), tier)
    yield baked()
    yield brushed()
    yield baked_live()
    yield baked_live(over_color=True)
    yield baked_metal()


@pytest.fixture(scope="module")
def texts():
    return [generate(made).text for made in all_made()]


@pytest.mark.parametrize("tier", ["baked", "auto", "analytic"])
@pytest.mark.parametrize("layers", [[], [{**COAT, "ior": 1.0}]])
def test_what_is_black_altogether_has_a_shader(layers, tier):
    made = make_lobe_set(Stack.from_dict({"layers": layers, "base": {"kind": "lambert", "color": [0, 0, 0]}}), tier)
    assert made.lobe_count >= 1 and "BSDF = lobe_0" in generate(made).text


@pytest.mark.blender
def test_patches_brushed_along_almost_the_same_direction_have_a_shader(blender):
    from lamina.addon.material.script_node import compile_shader

    metal = {"kind": "conductor", "metal": "gold", "roughness": 0.4, "anisotropy": 0.6, "rotation": 0.1}
    layers = [{**COAT, "roughness": 0.0}, {**metal, "rotation": 0.10001, "coverage": 0.5}]
    shader = generate(make_lobe_set(Stack.from_dict({"layers": layers, "base": metal}), "baked"))
    assert len(set(re.findall(r"vector (axis_\d+) =", shader.text))) == 2 and compile_shader(shader).bytecode


def compiles(folder, name: str, tmp_path) -> bool:
    """Whether oslc takes a shader that includes this file of a folder and nothing else."""
    pytest.importorskip("bpy")
    import _cycles

    shader = tmp_path / "trivial.osl"
    shader.write_text(TRIVIAL.format(folder / name), encoding="utf-8")
    return _cycles.osl_compile(str(shader), str(tmp_path / "trivial.oso"))


@pytest.mark.blender
@pytest.mark.parametrize("name", FILES)
def test_a_file_compiles_by_itself(name, tmp_path):
    assert compiles(osl_files.PARTS, name, tmp_path)


@pytest.mark.blender
@pytest.mark.parametrize("name, fault", [("film.h", '#include "fresnel_dielectric.h"\n'), ("medium.h", "#define TINT_FLOOR 1.0\n"), ("grid.h", "}\n")])
def test_a_file_that_does_not_stand_alone_is_found(name, fault, tmp_path):
    folder = shutil.copytree(osl_files.PARTS, tmp_path / "osl")
    text = (folder / name).read_text(encoding="utf-8")
    assert fault in text
    (folder / name).write_text(text.replace(fault, "", 1), encoding="utf-8")
    assert not compiles(folder, name, tmp_path)


@pytest.mark.parametrize("name", FILES)
def test_a_file_is_used(name, texts):
    text = osl_files.functions([name])
    functions = re.findall(r"^\w[\w ]*\(.*?^}", text, re.MULTILINE | re.DOTALL)
    assert functions and any(functions[-1] in shader for shader in texts)


@pytest.mark.parametrize("name", FILES)
def test_a_file_is_whole(name):
    """No placeholder is left to the generator, and of the constants that it fills in none is missing or idle."""
    text = (osl_files.PARTS / name).read_text(encoding="utf-8")
    assert text.startswith("// SPDX-License-Identifier: GPL-3.0-or-later\n#pragma once\n")
    assert "@" not in text
    for constant in re.findall(r"^#define (\w+) ", text, re.MULTILINE):
        assert constant in osl_files.constants()
        assert len(re.findall(rf"\b{constant}\b", text)) > 1


def test_constants_are_those_of_the_model(texts):
    """A shader has the generator's value of each constant, once, not that which lets a file stand alone."""
    for text in texts:
        defined = re.findall(r"^#define (\w+) (.*)$", text, re.MULTILINE)
        assert len(dict(defined)) == len(defined)
        assert all(value == osl_files.constants()[name] for name, value in defined)
        code = re.sub(r"//.*|^#define.*", "", text, flags=re.MULTILINE)
        assert set(re.findall(r"\b[A-Z][A-Z0-9]*_[A-Z0-9_]+\b", code)) <= {*dict(defined), "M_PI", "M_2PI", "M_PI_2"}


def coated(tier: str):
    return make_lobe_set(Stack.from_dict({"layers": [COAT, COAT], "base": METAL}), tier)


@pytest.mark.parametrize("made", [lambda: coated("analytic"), lambda: coated("weidlich_wilkie"), baked, baked_live], ids=["analytic", "paper", "baked", "live"])
def test_the_way_to_the_text_goes_one_way(made):
    """No module is called back while a call of its own is under way, and no two call each other."""
    lobe_set = made()
    doors = set()
    rooms: list[str] = []

    def watch(frame, event, _):
        name = frame.f_globals.get("__name__", "")
        if not name.startswith("lamina.addon.shader."):
            return
        if event == "return":
            rooms.pop()
        elif event == "call":
            if rooms and rooms[-1] != name:
                assert name not in rooms, f"{rooms[-1]} calls {name} back"
                doors.add((rooms[-1], name))
            rooms.append(name)

    sys.setprofile(watch)
    try:
        generate(lobe_set)
    finally:
        sys.setprofile(None)
    assert doors and not {(b, a) for a, b in doors} & doors
