# SPDX-License-Identifier: GPL-3.0-or-later
"""The job file: what it means, and one clear line for whatever is wrong with it."""

import json
import re
from pathlib import Path

import pytest

import lamina
from lamina.addon.batch.estimate import estimate
from lamina.addon.batch.items import Item, expand
from lamina.addon.batch.job import Job
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.material import presets

ONE = {"stacks": ["clean_copper"]}


def job(folder, **keys) -> Job:
    return Job.from_json(json.dumps(ONE | keys), folder / "job.json")


def test_everything_is_combined(tmp_path):
    sweeps = [{"parameter": "base.roughness", "values": [0.1, 0.2, 0.3]}, {"parameter": "base.metal", "values": ["gold", "silver"]}]
    made = expand(
        job(
            tmp_path,
            stacks=[{"name": "metal", "stack": {"base": {"kind": "conductor"}}}],
            sweeps=sweeps,
            qualities=["auto", "analytic"],
            views=[0, 90],
            frames="1-5x2",
        )
    )
    assert len(made) == 3 * 2 * 2 * 2 * 3 == len({item.id for item in made}) == len({item.inputs for item in made})
    assert {item.stack.base["metal"] for item in made} == {"gold", "silver"}
    assert sorted({item.frame for item in made}) == [1, 3, 5] and {item.seed for item in made} == {1, 3, 5}


def test_jobs_of_the_former_name_of_a_key_are_read(tmp_path):
    assert job(tmp_path, tiers=["analytic"]).qualities == job(tmp_path, qualities=["analytic"]).qualities == ("analytic",)


def test_steps_are_evenly_spread(tmp_path):
    made = expand(job(tmp_path, sweeps=[{"parameter": "base.roughness", "from": 0.1, "to": 0.3, "steps": 3}]))
    assert [item.stack.base["roughness"] for item in made] == pytest.approx([0.1, 0.2, 0.3])


def test_names_stay_when_a_job_grows_and_inputs_change_with_what_goes_in(tmp_path):
    small, large = expand(job(tmp_path)), expand(job(tmp_path, stacks=["glazed_mug", "clean_copper"], views=[0, 10], frames="1-3"))
    assert small[0].id in {item.id for item in large}
    for changed in ({"samples": 5}, {"size": 12}, {"seed": 3}, {"backend": "nodes"}):
        (other,) = expand(job(tmp_path, **changed))
        assert other.id == small[0].id and other.inputs != small[0].inputs


def test_coverage_and_blends_are_inputs_too(tmp_path):
    def hashes():
        layers = [{"kind": "dielectric", "coverage": c} for c in (0.2, 0.3)]
        looks = [{"name": "a", "stack": {"layers": [layer], "base": {"kind": "lambert"}}} for layer in layers]
        return [expand(job(tmp_path, stacks=[look], scenes=[{"blend": "s.blend", "object": "Cup"}]))[0].inputs for look in looks]

    (tmp_path / "s.blend").write_bytes(b"one")
    first = hashes()
    (tmp_path / "s.blend").write_bytes(b"two")
    assert len({*first, *hashes()}) == 4


def test_every_tier_says_what_it_chose_and_how_wrong_that_is():
    for tier, chosen in (("baked", "baked"), ("analytic", "analytic"), ("weidlich_wilkie", "weidlich_wilkie")):
        told = estimate(presets.load("polished_chrome"), tier, osl=True)
        assert told["lamina:chosen"] == chosen and told["lamina:error"].startswith("albedo 0.")


def test_a_picture_of_stock_nodes_tells_their_error():
    osl, stock = (estimate(presets.load("nail_polish"), "auto", osl) for osl in (True, False))
    errors = [float(told["lamina:error"].split("soft_light ")[1].split()[0]) for told in (osl, stock)]
    assert osl["lamina:chosen"] == "ramp, 1 glossy" and stock["lamina:chosen"].startswith("baked, ") and 3.0 * errors[0] < errors[1]


def test_items_travel_to_another_process(tmp_path):
    (tmp_path / "s.blend").write_bytes(b"one")
    made = expand(job(tmp_path, scenes=["ball", {"blend": "s.blend", "object": "Cup"}], sweeps=[{"parameter": "base.roughness", "values": [0.5]}]))
    assert [Item.from_dict(json.loads(json.dumps(item.to_dict()))) for item in made] == made


def test_the_job_in_the_manual_is_one(tmp_path):
    page = (Path(lamina.__file__).parent / "docs/technical-directors.md").read_text(encoding="utf-8")
    (text,) = (block for block in re.findall(r"```json\n(.*?)```", page, re.DOTALL) if '"stacks"' in block)
    assert len(expand(Job.from_json(text, tmp_path / "job.json"))) == 12


@pytest.mark.parametrize("name", ["../../../etc/passwd", "mein Lack für Ödön", "漆" * 40, "x" * 200, "a/b\\c:d*e?", "", ".", "\u202eexr"])
def test_any_name_makes_a_file_name_in_the_folder(tmp_path, name):
    made = expand(job(tmp_path, stacks=[{"name": name, "stack": {"base": {"kind": "lambert"}}}, {"name": name + "2", "stack": "clean_copper"}]))
    for item in made:
        (tmp_path / item.file).write_bytes(b"")
        assert item.file.isascii() and len(item.file) < 80 and (tmp_path / item.file).parent == tmp_path and item.file[0] not in "./"
    assert len({item.file for item in made}) == 2


BAD = [
    ({"sample": 4}, "unknown key 'sample'; did you mean 'samples'"),
    ({"lamina_job": 2}, "lamina_job 2 is newer than this Lamina"),
    ({"lamina_job": True}, "is no version"),
    ({"stacks": []}, "stacks must be a list of at least one"),
    ({"stacks": "clean_copper"}, "stacks must be a list"),
    ({"stacks": ["copper"]}, r"stacks\[0\]: unknown preset 'copper'; choose .*clean_copper"),
    ({"stacks": ["clean_copper", "clean_copper"]}, r"stacks\[1\]: 'clean_copper' is there already"),
    ({"stacks": ["../outside.json"]}, r"stacks\[0\]: '../outside.json' is outside of the job's folder"),
    ({"stacks": ["/etc/passwd.json"]}, "outside of the job's folder"),
    ({"stacks": ["link.json"]}, "outside of the job's folder"),
    ({"stacks": ["none.json"]}, "is no file in the job's folder"),
    ({"stacks": ["nul\0.json"]}, "is no name of a file"),
    ({"stacks": ["newer.json"]}, "schema_version 99 is newer"),
    ({"stacks": [{"name": "a", "stack": {"base": {"kind": "lambert"}, "layer": []}}]}, "did you mean 'layers'"),
    ({"stacks": [{"name": "a"}]}, "stack is missing"),
    ({"scenes": ["cube"]}, "scenes.0. is 'cube'"),
    ({"scenes": [{"blend": "../s.blend", "object": "Cup"}]}, "outside of the job's folder"),
    ({"scenes": [{"blend": "s.py", "object": "Cup"}]}, "must end in .blend"),
    ({"views": ["front"]}, r"views\[0\] is 'front'; choose degrees"),
    ({"views": [1e999]}, "Infinity is not a number"),
    ({"views": [0, 0.0]}, "is there already"),
    ({"frames": "10-1"}, "has no frames"),
    ({"frames": "1-999999"}, "more than 100000"),
    ({"frames": [1.5]}, "1.5 is no frame"),
    ({"frames": "1-100000000"}, "'1-100000000' is no frame; write numbers from -999999 to 999999 and ranges"),
    ({"size": 1}, "size is 1; choose a whole number from 2"),
    ({"samples": 0}, "samples is 0"),
    ({"time_limit": 0}, "time_limit is 0; choose seconds, more than 0"),
    ({"time_limit": "1 h"}, "time_limit is '1 h'; choose seconds"),
    ({"qualities": ["magic"]}, "unknown quality 'magic'; choose"),
    ({"backend": "cuda"}, "unknown backend 'cuda'; choose auto"),
    ({"sweeps": [{"parameter": "layers[0].roughness", "values": [0.1]}]}, "it has 0 layers"),
    # found by make fuzz: a name that breaks the line
    ({"stacks": [{"name": "a\nb", "stack": "clean_copper"}], "sweeps": [{"parameter": "layers[0].ior", "values": [1]}]}, "it has 0 layers"),
    ({"sweeps": [{"parameter": "base.roughnes", "values": [0.1]}]}, "conductor has no 'roughnes'; choose .*roughness"),
    ({"sweeps": [{"parameter": "__class__", "values": [0.1]}]}, r"write it like layers\[0\].roughness"),
    ({"sweeps": [{"parameter": "base.roughness", "values": [2]}]}, "roughness is 2; choose 0 to 1"),
    ({"sweeps": [{"parameter": "base.roughness", "from": 0, "to": 1, "steps": 1}]}, "steps is 1; choose"),
    ({"sweeps": [{"parameter": "base.roughness", "values": [0.5, 0.5]}]}, "same value twice"),
    ({"sweeps": [{"parameter": "base.roughness", "from": 0, "to": 1, "steps": 50_000}], "frames": "1-3"}, "150000 pictures; at most 100000"),
]


@pytest.mark.parametrize("keys, words", BAD)
def test_bad_jobs_are_one_line(tmp_path, keys, words):
    home = tmp_path / "home"
    home.mkdir()
    presets.load("clean_copper").save(tmp_path / "outside.json")
    (home / "link.json").symlink_to(tmp_path / "outside.json")
    (home / "newer.json").write_text('{"schema_version": 99, "base": {"kind": "lambert"}}')
    with pytest.raises(LaminaError, match=words) as raised:
        expand(job(home, **keys))
    assert "\n" not in str(raised.value) and len(str(raised.value)) < 1000 and "is no name of a file: /" not in str(raised.value)


@pytest.mark.parametrize("text, words", [
    ('{"stacks": ["clean_co', "not valid JSON at line 1"), ("[" * 100_000, "nested too deeply"), ("[" * 101 + "]" * 101, "nested too deeply"),
    ("[]", "a job is a JSON object"), ("{}", "a job needs 'stacks'"), ('{"stacks": NaN}', "NaN"), (" " * 10_000_000, "10000000 bytes is too large"),
    ('{"stacks": ["\\ud800"]}', "half a character"),
])  # fmt: skip
def test_broken_files_are_one_line(tmp_path, text, words):
    (tmp_path / "job.json").write_text(text)
    with pytest.raises(LaminaError, match=words):
        Job.load(tmp_path / "job.json")


def test_files_that_are_none(tmp_path):
    (tmp_path / "latin.json").write_bytes(b'{"name": "\xe9"}')
    for name, words in (("latin.json", "not UTF-8"), ("none.json", "No such file"), (".", "Is a directory"), ("n\0ul", "cannot read job file")):
        with pytest.raises(LaminaError, match=words):
            Job.load(f"{tmp_path}/{name}")
