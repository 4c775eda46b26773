# SPDX-License-Identifier: GPL-3.0-or-later
"""The installed zip in a real Blender, which LAMINA_BLENDER names: `blender -b --command lamina ...` is `lamina ...`."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from support.commands import lamina
from support.sunlit_ball import AGREE, means, picture, stage

import lamina as package

# Largest difference of a channel's mean in EEVEE from Cycles. It keeps light in numbers that lose up to 1.6 % of red and green, 3.1 % of blue.
EEVEE_AGREES = 0.035
BLENDER = os.environ.get("LAMINA_BLENDER", "")
pytestmark = [pytest.mark.blender, pytest.mark.skipif(not BLENDER, reason="LAMINA_BLENDER names no Blender")]


@pytest.fixture(scope="module")
def profile(tmp_path_factory) -> dict:
    """Arguments of subprocess for a Blender with a profile of its own, in which the extension is installed."""
    home = tmp_path_factory.mktemp("profile")
    environment = os.environ | {"BLENDER_USER_RESOURCES": str(home / "user"), "LAMINA_CACHE": str(home / "cache")}
    root = Path(package.__file__).resolve().parent
    subprocess.run([sys.executable, root / "tools" / "extension.py", "build", home], check=True, capture_output=True)
    install = [BLENDER, "-b", "--command", "extension", "install-file", "-r", "user_default", "-e", next(home.glob("*.zip"))]
    subprocess.run(install, check=True, capture_output=True, env=environment)
    return {"env": environment, "cwd": home, "text": True}


@pytest.fixture(scope="module")
def reads_pictures(profile):
    """Skips where this Blender's Python has no OpenImageIO, as that of a distribution may not, and batches are refused."""
    asked = [BLENDER, "-b", "--python-exit-code", "1", "--python-expr", "import OpenImageIO"]
    if subprocess.run(asked, capture_output=True, timeout=120, **profile).returncode:
        pytest.skip("the Blender that LAMINA_BLENDER names has no OpenImageIO (Debian: apt-get install python3-openimageio)")


@pytest.fixture(scope="module")
def blender(profile):
    """Runs that Blender; (lines of stdout without Blender's own, stderr)."""

    def run(*arguments, code=0):
        ran = subprocess.run([BLENDER, "-b", *map(str, arguments)], capture_output=True, timeout=600, **profile)
        assert ran.returncode == code, ran.stdout + ran.stderr
        assert "Traceback" not in ran.stderr
        return [line for line in ran.stdout.splitlines() if line and not line.startswith("Blender ")], ran.stderr

    return run


def test_numbers_and_refusals_are_those_of_the_wheel(blender):
    for arguments in (["presets"], ["schema", "--json"], ["albedo", "clean_copper"], ["shader", "clean_copper", "--tier", "weidlich_wilkie"]):
        assert blender("--command", "lamina", *arguments)[0] == [line for line in lamina(*arguments)[0].splitlines() if line]
    for arguments in (["albedo", "nope"], ["batch", "none.json"], ["frobnicate"]):
        told = lamina(*arguments, code=2)[1].replace(", 'chart', 'figures'", "")  # which a checkout has besides
        assert told in blender("--command", "lamina", *arguments, code=2)[1]


def test_a_batch_and_its_bundle_in_a_blender_without_lamina(blender, tmp_path, reads_pictures):
    job = tmp_path / "job.json"
    job.write_text(json.dumps({"stacks": ["clean_copper"], "qualities": ["weidlich_wilkie"], "size": 16, "samples": 2}))
    blender("--command", "lamina", "batch", job, "-o", tmp_path / "here", "--no-sheet")
    blender("--command", "lamina", "farm", job, "-o", tmp_path / "bundle")
    files = tmp_path / "bundle" / "files"
    blender("--factory-startup", "--python-exit-code", "1", "--python", files / "render_items.py", "--", "--items", files / "items.json", "--range", "0",
            "--output", tmp_path / "farmed")  # fmt: skip
    _, said = blender("--command", "lamina", "batch", job, "-o", tmp_path / "farmed", "--no-sheet")
    assert "1 pictures, 1 of them are there and whole" in said

    def pixels(folder):
        with open(folder / "batch.csv", newline="") as file:
            return [row["pixels"] for row in csv.DictReader(file)]

    assert pixels(tmp_path / "here") == pixels(tmp_path / "farmed")


def osl_of(blender) -> bool:
    return "OSL True" in blender("--python-expr", "import _cycles; print('OSL', _cycles.with_osl)")[0]


def test_a_bundle_of_osl_shaders_is_refused_where_there_is_no_osl(blender, tmp_path):
    """Written by the wheel, which has OSL. Where there is some, it renders."""
    job = tmp_path / "job.json"
    job.write_text(json.dumps({"stacks": ["clean_copper"], "qualities": ["weidlich_wilkie"], "backend": "osl", "size": 4, "samples": 1}))
    lamina("farm", job, "-o", tmp_path / "bundle")
    files = tmp_path / "bundle" / "files"
    has_osl = osl_of(blender)
    told, _ = blender("--factory-startup", "--python", files / "render_items.py", "--", "--items", files / "items.json", "--range", "0",
                      "--output", tmp_path / "farmed", code=0 if has_osl else 1)  # fmt: skip
    assert has_osl or any("is an OSL script alone, and this Blender was built without OSL; give the job the backend auto or nodes" in line for line in told)
    assert len(list((tmp_path / "farmed").glob("*.exr"))) == has_osl


def test_osl_where_there_is_none_is_code_2(blender, tmp_path, reads_pictures):
    """Of a Blender with OSL, that it is there."""
    job = tmp_path / "job.json"
    job.write_text(json.dumps({"stacks": ["clean_copper"], "qualities": ["weidlich_wilkie"], "backend": "osl", "size": 4, "samples": 1}))
    has_osl = osl_of(blender)
    _, said = blender("--command", "lamina", "batch", job, "-o", tmp_path / "out", "--no-sheet", code=0 if has_osl else 2)
    assert has_osl or "needs Cycles with OSL" in said


def test_ctrl_c_is_130_as_in_the_wheel(profile, tmp_path, reads_pictures):
    job = tmp_path / "job.json"
    job.write_text(json.dumps({"stacks": ["clean_copper"], "qualities": ["weidlich_wilkie"], "size": 256, "samples": 100_000}))
    command = [BLENDER, "-b", "--command", "lamina", "batch", str(job), "-o", str(tmp_path / "out")]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, **profile)
    assert "0 of them" in process.stderr.readline()
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    error = process.communicate(timeout=60)[1]
    assert process.returncode == 130 and error.strip().splitlines()[-1] == "lamina: cancelled"
    assert not list((tmp_path / "out").iterdir())


def test_one_file_in_the_wheel_and_there_in_cycles_and_in_eevee(registered_lamina, tmp_path):
    """A Blender without Lamina, and maybe without OSL, opens what the wheel saved."""
    import bpy

    from lamina.addon.material.material import apply_stack
    from lamina.reference_py.material.stack import Stack
    from lamina.study.viewport.eevee_pictures import eevee_pictures

    bpy.ops.wm.read_factory_settings(use_empty=True)
    glaze = {"kind": "dielectric", "roughness": 0.2, "tint": [0.6, 0.8, 0.9]}
    owner = bpy.data.materials.new("owner")
    apply_stack(owner, Stack.from_dict({"layers": [glaze], "base": {"kind": "lambert", "color": [0.6, 0.3, 0.2]}}), "baked")
    path, there = stage(owner, tmp_path), tmp_path / "there.exr"
    here = picture(tmp_path, osl=False)
    render = f"import bpy; bpy.context.scene.render.filepath = {str(there)!r}; bpy.ops.render.render(write_still=True)"
    subprocess.run([BLENDER, "-b", "--factory-startup", path, "--python-exit-code", "1", "--python-expr", render], check=True, capture_output=True, timeout=300)
    assert here.min() > 0.01 and np.all(np.abs(means(there) / here - 1.0) < AGREE)
    (eevee,) = eevee_pictures(bpy.context.scene, bpy.data.objects["ball"], [owner], 16, lambda message: None)
    assert np.all(np.abs(eevee.mean(axis=(0, 1)) / here - 1.0) < EEVEE_AGREES), eevee.mean(axis=(0, 1)) / here


_GERMAN = """
import bpy, importlib, json
translation = importlib.import_module("bl_ext.user_default.lamina.addon.blender.translation")
view = bpy.context.preferences.view
view.language = "de_DE"
view.use_translate_interface = view.use_translate_tooltips = view.use_translate_reports = True
ours = translation.load("de_DE")
blenders = [text for text, said in ours.items() if bpy.app.translations.pgettext_iface(text) != said]
shown = {text: [act(text) for act in (translation.iface_, translation.tip_, translation.rpt_)] for text in ours}
labels = [bpy.app.translations.pgettext_iface(rna.name, rna.translation_context) for rna in (bpy.ops.lamina.layer_add.get_rna_type(),
          bpy.types.Material.bl_rna.properties["lamina"].fixed_type.properties["tier"])]
print("SAID", json.dumps([blenders, [text for text, said in shown.items() if set(said) != {ours[text]}], labels]))
"""


def test_our_own_german_is_shown_where_blender_has_another(blender):
    """Blender looks into its own catalogue first; so what Lamina shows is in a context that it does not know."""
    lines = blender("--python-exit-code", "1", "--python-expr", _GERMAN)[0]
    blenders, wrong, labels = json.loads(next(line for line in lines if line.startswith("SAID ")).removeprefix("SAID "))
    assert {"Layer", "Base"} & set(blenders) and wrong == []
    ours = json.loads((Path(package.__file__).parent / "addon" / "translations" / "de_DE.json").read_text(encoding="utf-8"))
    assert labels == [ours["Add Layer"], ours["Quality"]]
    print(blenders)
