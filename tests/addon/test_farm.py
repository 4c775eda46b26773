# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina farm`: a bundle that a Blender without Lamina renders, here by Open Job Description's own runner."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from support import wheel_blender
from support.commands import lamina

pytest.importorskip("bpy")

pytestmark = pytest.mark.blender

NAME = "Größe & Lack, 漆 " + "x" * 183
JOB = {"stacks": [{"name": NAME, "stack": "clean_copper"}], "qualities": ["weidlich_wilkie"], "views": [0, 40], "size": 16, "samples": 2}


@pytest.fixture(scope="module")
def bundle(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("farm") / NAME
    folder.mkdir()
    (folder / "job.json").write_text(json.dumps(JOB))
    lamina("farm", folder / "job.json", "-o", folder / "bundle", "--chunk", 2)
    return folder


@pytest.fixture(scope="module")
def blender_program(tmp_path_factory) -> str:
    """The wheel in the clothes of a Blender; for a real one see test_real_blender."""
    return wheel_blender.blender_program(tmp_path_factory.mktemp("bin"))


def openjd() -> str:
    """The runner of Open Job Description, beside this Python or on the PATH."""
    beside = Path(sys.executable).with_name("openjd")
    found = str(beside) if beside.exists() else shutil.which("openjd")
    if not found:
        pytest.skip("openjd is not installed: pip install openjd-cli")
    return found


def test_open_job_description_runs_the_bundle_and_the_batch_takes_it_over(bundle, blender_program, tmp_path):
    """Equal to what `lamina batch` renders itself, to the last bit."""
    template = bundle / "bundle" / "template.json"
    subprocess.run([openjd(), "check", template], check=True, capture_output=True)
    parameters = [f"-pBlender={blender_program}", f"-pOutput={tmp_path / 'farmed'}"]
    ran = subprocess.run([openjd(), "run", template, "--step", "Render", *parameters], capture_output=True, text=True, timeout=300)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert "Chunks run: 1" in ran.stdout and "openjd_progress: 100.0" in ran.stdout
    _, said = lamina("batch", bundle / "job.json", "-o", tmp_path / "farmed", "--no-sheet")
    assert "2 pictures, 2 of them are there and whole" in said
    lamina("batch", bundle / "job.json", "-o", tmp_path / "here", "--no-sheet", "--processes", 1)

    def pixels(folder):
        lines = (folder / "batch.csv").read_text().splitlines()
        return [re.sub(r",\d+\.\d\d,(?=\d+\.\d+\.\d+,)", ",", line) for line in lines]  # without the seconds

    assert pixels(tmp_path / "farmed") == pixels(tmp_path / "here")


def test_deadline_cloud_reads_the_bundle(bundle):
    """By that vendor's own library, without an account: the folders that travel and come back, and all parameters."""
    pytest.importorskip("deadline.client.job_bundle", reason="deadline is not installed: pip install deadline")
    from deadline.client.job_bundle import loader, parameters, submission

    folder = str(bundle / "bundle")
    loader.validate_directory_symlink_containment(folder)
    assert loader.read_yaml_or_json_object(folder, "template", True)["specificationVersion"] == "jobtemplate-2023-09"
    found, travels = parameters.read_job_bundle_parameters(folder), submission.AssetReferences()
    parameters.apply_job_parameters([], folder, found, travels)
    assert {p["name"] for p in found} == {"Files", "Output", "Blender", "Pictures", "PicturesPerTask"}
    assert travels.input_directories == {f"{folder}/files"} and travels.output_directories == {f"{folder}/output"}


def test_a_failed_picture_fails_its_task_and_no_other(bundle, blender_program, tmp_path):
    shutil.copytree(bundle / "bundle" / "files", tmp_path / "files")
    items = json.loads((tmp_path / "files" / "items.json").read_text())
    items["items"][0]["material_file"] = "materials/lost.blend"
    (tmp_path / "files" / "items.json").write_text(json.dumps(items))
    ran = subprocess.run([blender_program, "-b", "--python", str(tmp_path / "files" / "render_items.py"), "--", "--items", str(tmp_path / "files" / "items.json"),
                          "--range", "0-1", "--output", str(tmp_path / "out")], capture_output=True, text=True, timeout=300)  # fmt: skip
    assert ran.returncode == 1 and f"lamina: failed: {items['items'][0]['id']}" in ran.stdout
    assert [f.name for f in (tmp_path / "out").iterdir()] == [items["items"][1]["file"]]
    before = (tmp_path / "out" / items["items"][1]["file"]).read_bytes()
    items["items"][1]["inputs"] = "another job's"
    (tmp_path / "files" / "items.json").write_text(json.dumps(items))
    ran = subprocess.run([blender_program, "-b", "--python", str(tmp_path / "files" / "render_items.py"), "--", "--items", str(tmp_path / "files" / "items.json"),
                          "--range", "1", "--output", str(tmp_path / "out")], capture_output=True, text=True, timeout=300)  # fmt: skip
    assert ran.returncode == 1 and "is of other inputs; choose another folder" in ran.stdout
    assert (tmp_path / "out" / items["items"][1]["file"]).read_bytes() == before


def test_a_picture_that_takes_too_long_ends_its_task(bundle, blender_program, tmp_path):
    shutil.copytree(bundle / "bundle" / "files", tmp_path / "files")
    items = json.loads((tmp_path / "files" / "items.json").read_text())
    (tmp_path / "files" / "items.json").write_text(json.dumps(items | {"time_limit": 0.01}))
    ran = subprocess.run([blender_program, "-b", "--python", str(tmp_path / "files" / "render_items.py"), "--", "--items", str(tmp_path / "files" / "items.json"),
                          "--range", "0-1", "--output", str(tmp_path / "out")], capture_output=True, text=True, timeout=300)  # fmt: skip
    assert ran.returncode == 1 and f"{items['items'][0]['id']} failed: took longer than the job's time_limit of 0.01 s" in ran.stdout
    assert not list((tmp_path / "out").iterdir())


def test_flamenco_compiles_the_job_type_into_tasks(bundle, tmp_path):
    """Run by node, with the few things that Flamenco gives a job compiler."""
    node = shutil.which("node")
    if not node:
        pytest.skip("node is not installed")
    script = (
        (bundle / "bundle" / "lamina_flamenco.js").read_text()
        + """
const tasks = [];
const author = {
  Task: (name, type) => ({ name, type, commands: [], addCommand(c) { this.commands.push(c); } }),
  Command: (name, parameters) => ({ name, parameters }),
};
const settings = Object.fromEntries(JOB_TYPE.settings.map((s) => [s.key, s.default]));
compileJob({ settings: { ...settings, files: "/f", output: "/o", pictures: 5 }, addTask: (t) => tasks.push(t) });
console.log(JSON.stringify({ label: JOB_TYPE.label, own: settings, tasks }));
"""
    )
    told = json.loads(subprocess.run([node, "-e", script], capture_output=True, text=True, check=True).stdout)
    assert told["label"] == "Lamina: job" and told["own"] == {"pictures": 2, "pictures_per_task": 2}
    assert [t["name"] for t in told["tasks"]] == ["render-0-1", "render-2-3", "render-4-4"] and {t["type"] for t in told["tasks"]} == {"blender"}
    arguments = told["tasks"][2]["commands"][0]["parameters"]["args"]
    assert arguments[arguments.index("--range") + 1] == "4-4" and arguments[arguments.index("--items") + 1] == "/f/items.json"


def test_bad_input_leaves_nothing(bundle, tmp_path):
    _, said = lamina("farm", bundle / "job.json", "-o", bundle / "bundle", code=2)
    assert len(said.splitlines()) == 1 and "is not empty; choose a new one" in said
    (tmp_path / "job.json").write_text("{}")
    lamina("farm", tmp_path / "job.json", "-o", tmp_path / "new", code=2)
    assert not (tmp_path / "new").exists()


def test_what_fails_half_way_leaves_nothing_and_can_be_tried_again(tmp_path):
    """A .blend that breaks the farm after the first material; baked stock nodes; a folder that was there, empty."""
    (tmp_path / "broken.blend").write_bytes(b"BLENDER")
    (tmp_path / "out").mkdir()
    job = {"stacks": ["polished_chrome"], "views": [0, 90], "size": 16, "samples": 2, "qualities": ["baked"], "backend": "nodes"}
    for keys, code in (({"scenes": ["ball", {"blend": "broken.blend", "object": "Cup"}]}, 2), ({}, 0)):
        (tmp_path / "job.json").write_text(json.dumps(job | keys))
        _, said = lamina("farm", tmp_path / "job.json", "-o", tmp_path / "out", code=code)
        if code:
            assert "broken.blend: Blender cannot open it" in said.splitlines()[-1]
            assert not list((tmp_path / "out").iterdir()) and len(list(tmp_path.iterdir())) == 3
    assert f"openjd run {tmp_path}/out/template.json --step Render -p Blender=blender -p Output=" in said and f"lamina batch {tmp_path}/job.json -o" in said
    items = json.loads((tmp_path / "out" / "files" / "items.json").read_text())["items"]
    assert [item["texts"]["lamina:chosen"] for item in items] == ["baked", "baked"] and len(list(tmp_path.iterdir())) == 3
