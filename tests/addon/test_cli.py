# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line as its user meets it: a process of its own, its output, its exit code, nothing half-written."""

import json
import os
import shlex
import signal
import stat
import subprocess
import sys

import numpy as np
import pytest
from support.commands import RUN, lamina

from lamina.reference_py.material import presets
from lamina.reference_py.material.stack import Stack
from lamina.reference_py.optics.frame import spherical
from lamina.reference_py.registry import MODELS, make_model
from lamina.reference_py.version import version


def test_albedo_prints_the_documented_json():
    out, _ = lamina("albedo", "glazed_mug", "--model", "weidlich_wilkie", "--theta", 0, 30, 60, "--json")
    data = json.loads(out)
    assert data["model"] == "weidlich_wilkie" and data["theta_deg"] == [0, 30, 60]
    expected = make_model("weidlich_wilkie", presets.load("glazed_mug")).albedo(spherical(np.radians([0, 30, 60]), 0.0))
    assert np.array(data["albedo"]) == pytest.approx(expected)
    assert "stderr" not in data


def test_stochastic_models_print_their_standard_error():
    out, _ = lamina("albedo", "glazed_mug", "--model", "position_free", "--option", "walks=2000", "--theta", 20, "--json")
    data = json.loads(out)
    assert np.shape(data["stderr"]) == np.shape(data["albedo"]) == (1, 3)
    assert np.all(np.array(data["stderr"]) > 0.0)


def test_eval_prints_f_for_every_light_direction():
    out, _ = lamina("eval", "frosted_paint", "--model", "mirror", "--option", "tier=analytic", "--wo", "30,0", "--wi", "30,180", "50,90", "--json")
    data = json.loads(out)
    wi = spherical(np.radians([30, 50]), np.radians([180, 90]))
    wo = np.broadcast_to(spherical(np.radians(30), 0.0), wi.shape)
    assert np.array(data["f"]) == pytest.approx(make_model("closure_model", presets.load("frosted_paint"), method="analytic").f(wo, wi))


def test_eval_prints_a_table_of_a_grid():
    out, _ = lamina("eval", "glazed_mug", "--model", "position_free", "--option", "walks=64", "--wo", "30,0", "--grid", 30, "--csv")
    header, *rows = out.splitlines()
    assert header == "theta_o,phi_o,theta_i,phi_i,r,g,b,r_stderr,g_stderr,b_stderr"
    table = np.array([[float(v) for v in row.split(",")] for row in rows])
    assert table.shape == (1 + 2 * 12, 10) and np.all(table[:, :2] == [30.0, 0.0]) and set(table[:, 2]) == {0.0, 30.0, 60.0}
    wi = spherical(np.radians(table[:, 2]), np.radians(table[:, 3]))
    f, stderr = make_model("position_free", presets.load("glazed_mug"), walks=64).f_stderr(spherical(np.radians(30.0), 0.0), wi)
    assert table[:, 4:] == pytest.approx(np.concatenate([f, stderr], axis=1), rel=1e-5)


def test_plot_writes_a_picture_or_nothing(tmp_path):
    lamina("plot", "glazed_mug", "--model", "weidlich_wilkie", "--theta", 20, "-o", tmp_path / "mug.svg")
    assert "view 20" in (tmp_path / "mug.svg").read_text(encoding="utf-8")
    _, err = lamina("plot", "glazed_mug", "-o", tmp_path / "mug.gif", code=2)
    assert err.count("\n") == 1 and "choose a name that ends in .svg" in err and not (tmp_path / "mug.gif").exists()


def test_json_says_how_to_get_the_numbers_again():
    out, _ = lamina("albedo", "glazed_mug", "--model", "adding", "--option", "nodes=40", "--surface", "single", "--theta", 0, "--json")
    data = json.loads(out)
    assert data["options"] == {"surface": "single", "nodes": "40"} and data["version"] == version()
    again = make_model("adding", Stack.from_dict(data["stack"]), surface="single", nodes=40)
    assert np.array(data["albedo"][0]) == pytest.approx(again.albedo(np.array([0.0, 0.0, 1.0])))


def test_an_option_given_twice_is_refused():
    _, err = lamina("albedo", "glazed_mug", "--model", "adding", "--surface", "single", "--option", "surface=multiple", code=2)
    assert err.count("\n") == 1 and "surface is given already, as 'single'" in err


def test_a_misspelt_layers_is_named_once(tmp_path):
    path = tmp_path / "typo.json"
    path.write_text('{"layer": [{"kind": "dielectric"}], "base": {"kind": "lambert"}}')
    _, err = lamina("albedo", path, "--theta", 0)
    assert err.count("did you mean 'layers'?") == 1


def test_eval_says_when_a_truth_is_out_of_its_depth():
    _, err = lamina("eval", "metal_foil", "--model", "adding", "--wo", "30,0", "--wi", "30,180")
    assert "position_free" in err


def test_version_and_closed_pipes():
    assert lamina("--version")[0] == f"lamina {version()}\n"
    first = subprocess.run(f"{shlex.join(RUN)} schema | head -1", shell=True, capture_output=True, text=True, timeout=60)
    assert "Traceback" not in first.stderr
    with open("/dev/full", "w") as full:
        result = subprocess.run([*RUN, "schema"], stdout=full, stderr=subprocess.PIPE, text=True, timeout=60)
    assert result.returncode == 1 and result.stderr == "lamina: cannot write the output: No space left on device\n"


def test_explain_says_what_was_tried_and_chosen():
    out, _ = lamina("explain", "glazed_mug", "--json")
    data = json.loads(out)
    assert data["chosen"] in [row["label"] for row in data["tried"]]
    assert all(row["albedo"] < 0.01 for row in data["tried"] if row["label"].startswith("baked"))
    assert "chosen: " in lamina("explain", "glazed_mug")[0]


def test_explain_of_a_cloudy_stack(tmp_path):
    cloudy = {"kind": "dielectric", "scatter_color": [0.9, 0.9, 0.9], "density": 3.0}
    files = [tmp_path / "cloudy.json", tmp_path / "brushed.json"]
    for file, brushed in zip(files, ({}, {"anisotropy": 0.5})):
        file.write_text(json.dumps({"layers": [{**cloudy, **brushed}], "base": {"kind": "lambert"}}))
    tried = json.loads(lamina("explain", files[0], "--json")[0])["tried"]
    assert tried and all(row["label"].startswith(("baked", "ramp")) for row in tried)
    _, told = lamina("explain", files[1], code=2)
    assert told.splitlines()[-1] == "lamina: a medium that scatters cannot be had together with the anisotropy of Dielectric; choose one of the two"


def test_tables_name_their_model():
    assert lamina("albedo", "clean_copper")[0].startswith("adding: ")
    assert lamina("eval", "clean_copper", "--model", "mirror", "--option", "tier=analytic", "--wo", "30,0", "--wi", "30,180")[0].startswith(
        "closure_model: f in 1/sr"
    )


def test_lists():
    assert set(json.loads(lamina("models", "--json")[0])["models"][0]) == {"name", "stochastic"}
    assert [m["name"] for m in json.loads(lamina("models", "--json")[0])["models"]] == list(MODELS)
    assert [p["name"] for p in json.loads(lamina("presets", "--json")[0])["presets"]] == presets.names()


def test_a_stack_file_with_spaces_and_unicode(tmp_path):
    path = tmp_path / "mein Lack für Ödön.json"
    presets.load("crayon_paint").save(path)
    assert lamina("albedo", path)[0] == lamina("albedo", "crayon_paint")[0]


def test_shader_is_printed_without_bpy():
    out, _ = lamina("shader", "metallic_car_paint", "--tier", "analytic")
    assert out.startswith("// SPDX-License-Identifier: GPL-3.0-or-later\n// Lamina shader") and "Layer1Ior" in out and "BaseEta" in out


def test_commands_without_blender_start_at_once():
    """In less CPU time than reading numpy takes, the least of three in turn; it was half of it."""

    def seconds(act):
        before = os.times()
        act()
        after = os.times()
        return after.children_user + after.children_system - before.children_user - before.children_system

    numpy = [sys.executable, "-c", "import numpy"]
    spent = [(seconds(lambda: lamina("albedo", "--help")), seconds(lambda: subprocess.run(numpy, check=True))) for _ in range(3)]
    command, reading = map(min, zip(*spent))
    assert command < reading


BAD = [
    (["albedo", "nope"], ["unknown preset 'nope'", "crayon_paint"]),
    (["albedo", "missing.json"], ["missing.json", "No such file"]),
    (["albedo", "crayon_paint", "--model", "phong"], ["unknown model 'phong'", "weidlich_wilkie"]),
    (["albedo", "crayon_paint", "--theta", "90"], ["--theta 90", "0 to below 90"]),
    (["albedo", "crayon_paint", "--theta", "nan"], ["--theta nan"]),
    (["albedo", "crayon_paint", "--model", "weidlich_wilkie", "--option", "refraction=up"], ["refraction 'up'", "half_vector, macro_normal"]),
    (["albedo", "crayon_paint", "--option", "refraction"], ["NAME=VALUE"]),
    (["eval", "crayon_paint", "--wo", "10", "--wi", "1,2"], ["direction '10'", "THETA,PHI"]),
    (["render", "crayon_paint"], ["-o FILE"]),
    (["render", "crayon_paint", "-o", "x.jpg"], ["'.jpg'", ".exr or .png"]),
    (["render", "crayon_paint", "-o", "none/x.png"], ["none", "No such file"]),
    (["render", "crayon_paint", "-o", "x.png", "--samples", "0"], ["--samples", "0 is out of range", "1 to 1000000"]),
    (["render", "crayon_paint", "-o", "x.png", "--size", "9" * 12], ["--size", "out of range", "2 to 16384"]),
    (["render", "crayon_paint", "-o", "x.png", "--json"], ["--json goes with --scene furnace"]),
    (["render", "crayon_paint", "-o", "x.png", "--scene", "furnace"], ["leave out -o x.png"]),
    (["demo", "-o", "/proc/none"], ["/proc/none", "cannot make this folder"]),
    (["apply", "--stack", "crayon_paint", "--object", "Cube", "none.blend", "-o", "x.txt"], ["x.txt", ".blend"]),
    (["render", "crayon_paint", "-o", "x.png", "--backend", "cuda"], ["--backend", "'cuda'", "auto", "osl", "nodes"]),
    (["render", "crayon_paint", "-o", "x.png", "--tier", "magic"], ["quality 'magic'", "weidlich_wilkie"]),
    (["apply", "--stack", "crayon_paint", "--object", "Cube", "none.blend", "-o", "x.blend"], ["none.blend", "no such"]),
    (["frobnicate"], ["frobnicate", "albedo"]),
    ([], ["COMMAND"]),
]


@pytest.mark.parametrize("arguments, words", BAD)
def test_bad_input_is_one_line_and_code_2(arguments, words, tmp_path):
    out, error = lamina(*arguments, code=2, cwd=tmp_path)
    assert out == "" and len(error.strip().splitlines()) == 1
    for word in words:
        assert word in error
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "text, words",
    [
        ('{"base": ', ["line 1 column"]),
        ("{}", ["empty"]),
        ('{"base": {"kind": "lambert"}, "layers": [{"kind": "dielectric", "ior": NaN}]}', ["NaN"]),
        ('{"base": {"kind": "lambert"}, "layers": [{"kind": "dielectric", "ior": 9}]}', ["ior is 9", "1 to 4"]),
        ('{"base": {"kind": "lambert"}, "layers": [{"kind": "slime"}]}', ["'slime'", "dielectric"]),
    ],
)
def test_bad_stack_files(text, words, tmp_path):
    (tmp_path / "bad.json").write_text(text)
    _, error = lamina("albedo", "bad.json", code=2, cwd=tmp_path)
    assert len(error.strip().splitlines()) == 1
    for word in ["bad.json", *words]:
        assert word in error


def test_a_misspelt_key_is_named_and_the_work_goes_on(tmp_path):
    (tmp_path / "typo.json").write_text('{"base": {"kind": "lambert"}, "layers": [{"kind": "dielectric", "rougness": 0.5}]}')
    out, error = lamina("albedo", "typo.json", cwd=tmp_path)
    assert out and "layer 0" in error and "'rougness'" in error and "'roughness'" in error


def test_schema_lists_every_key():
    out, _ = lamina("schema")
    data = json.loads(lamina("schema", "--json")[0])
    for kind in data["layers"] | data["base"]:
        assert kind in out
        for name, row in (data["layers"] | data["base"])[kind].items():
            assert name in out and row["allowed"] in out


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_without_permission(tmp_path):
    tmp_path.chmod(stat.S_IRUSR | stat.S_IXUSR)
    _, error = lamina("render", "crayon_paint", "-o", tmp_path / "x.png", code=2)
    assert "Permission denied" in error


@pytest.mark.blender
def test_render_writes_both_formats_and_furnace_prints_json(tmp_path, blender):
    from lamina.addon.blender.images import read_exr, read_png

    lamina("render", "metal_foil", "--scene", "sphere", "--tier", "analytic", "-o", "a.exr", "--size", 24, "--samples", 4, cwd=tmp_path)
    red = read_exr(tmp_path / "a.exr").channels["R"]
    assert red.shape == (24, 24) and np.isfinite(red).all()
    out, error = lamina("render", "clean_copper", "--tier", "analytic", "-o", "b.png", "--size", 32, "--samples", 1, cwd=tmp_path)
    assert out == "" and "wrote b.png" in error
    assert read_png(tmp_path / "b.png")[0].shape[:2] == (32, 32)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.exr", "b.png"]
    out, _ = lamina("render", "clean_copper", "--scene", "furnace", "--theta", 0, 60, "--samples", 16, "--size", 8, "--json")
    data = json.loads(out)
    expected = make_model("closure_model", presets.load("clean_copper")).albedo(spherical(np.radians([0, 60]), 0.0))
    assert np.shape(data["stderr"]) == (2, 3)
    assert np.array(data["albedo"]) == pytest.approx(expected, abs=5e-3)
    out, _ = lamina("render", "clean_copper", "--scene", "furnace", "--theta", 0, 60, "--samples", 16, "--size", 8, "--json", "--backend", "nodes")
    assert np.array(json.loads(out)["albedo"]) == pytest.approx(expected, abs=5e-3)


@pytest.mark.blender
def test_cancel_is_code_130_and_leaves_nothing(tmp_path, blender):
    # of a size at which Cycles, which ends where no noise is left, takes far longer than this test
    process = subprocess.Popen(
        [*RUN, "render", "crayon_paint", "-o", str(tmp_path / "x.png"), "--samples", "100000", "--size", "192"],
        stderr=subprocess.PIPE,
        text=True,
    )
    for line in process.stderr:
        if "Sample" in line:
            break
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=120)
    assert process.returncode == 130, error
    assert error.strip().splitlines()[-1] == "lamina: cancelled" and "Traceback" not in error
    assert list(tmp_path.iterdir()) == []


@pytest.mark.blender
def test_apply_says_what_the_scene_will_show(tmp_path, blender):
    """Stock nodes where the scene shows no scripts, and black where there are none; the file's render is left as it was."""
    import bpy

    bpy.context.collection.objects.link(bpy.data.objects.new("Thing", bpy.data.meshes.new("Thing")))
    bpy.context.scene.render.engine = "CYCLES"
    bpy.context.view_layer.aovs.add().name = "mask"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "in.blend"))
    for backend, expected in (("auto", "Shown by stock nodes, as the shader AOV mask would be black"), ("osl", "Black: the shader is an OSL script alone, and the shader AOV mask"),
                              ("nodes", "")):  # fmt: skip
        how = ("--tier", "analytic", "--backend", backend)
        _, said = lamina("apply", "--stack", "crayon_paint", "--object", "Thing", "in.blend", "-o", "out.blend", *how, cwd=tmp_path)
        assert expected in said and len(said.splitlines()) == (3 if expected else 2)


def test_apply_gives_an_object_the_material(tmp_path, blender):
    import bpy

    mesh = bpy.data.meshes.new("Thing")
    bpy.context.collection.objects.link(bpy.data.objects.new("Thing", mesh))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "in.blend"))
    _, said = lamina("apply", "--stack", "glazed_mug", "--object", "Thing", "in.blend", "-o", "out.blend", cwd=tmp_path)
    assert "Shown by stock nodes, as the render engine is not Cycles" in said
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "out.blend"))
    from lamina.addon.material.material import stack_of

    (material,) = bpy.data.objects["Thing"].data.materials
    assert stack_of(material).to_dict() == presets.load("glazed_mug").to_dict()
    assert bpy.context.scene.render.engine != "CYCLES", "another engine is left alone"
    _, said = lamina("apply", "--stack", "glazed_mug", "--object", "Thing", "in.blend", "-o", "nodes.blend", "--backend", "nodes", cwd=tmp_path)
    assert "render engine" not in said
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "nodes.blend"))
    from lamina.addon.material.shader_node import backend_of

    assert backend_of(bpy.data.objects["Thing"].active_material) == "nodes"
    _, error = lamina("apply", "--stack", "glazed_mug", "--object", "Other", "in.blend", "-o", "o2.blend", code=2, cwd=tmp_path)
    assert "'Other'" in error and "Thing" in error
    (tmp_path / "broken.blend").write_bytes(b"not a blend")
    _, error = lamina("apply", "--stack", "glazed_mug", "--object", "Thing", "broken.blend", "-o", "o2.blend", code=2, cwd=tmp_path)
    assert "broken.blend" in error
    assert sorted(p.name for p in tmp_path.iterdir()) == ["broken.blend", "in.blend", "nodes.blend", "out.blend"]


def test_the_cache_is_shown_and_cleaned(tmp_path):
    folder = tmp_path / "bäkes 漆"
    environment = os.environ | {"LAMINA_CACHE": str(folder)}
    said, _ = lamina("cache", env=environment)
    assert str(folder) in said and "not made yet" in said and not folder.exists()
    for _ in range(2):
        lamina("shader", "clean_copper", "--tier", "baked", env=environment)
    told = json.loads(lamina("cache", "--json", env=environment)[0])
    assert told["folder"] == str(folder) and told["files"] >= 1 and told["hits"] >= 1
    assert told["size"] == sum(f.stat().st_size for f in folder.glob("*.json"))
    assert "removed 0 files" in lamina("cache", "--clean", "--older-than", 1, env=environment)[0]
    assert f"removed {told['files']} files" in lamina("cache", "--clean", env=environment)[0] and not list(folder.iterdir())
    assert "--older-than goes with --clean" in lamina("cache", "--older-than", 1, code=2, env=environment)[1]
    (tmp_path / "file").write_text("")
    assert "this is a file" in lamina("cache", code=2, env=environment | {"LAMINA_CACHE": str(tmp_path / "file")})[1]
