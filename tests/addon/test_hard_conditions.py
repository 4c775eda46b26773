# SPDX-License-Identifier: GPL-3.0-or-later
"""Full and read-only disks, kills within a bake, broken caches: nothing lost, nothing half-written, one clear line each."""

import json
import os
import subprocess
import time

import numpy as np
import pytest
from support.commands import RUN, lamina

from lamina.reference_py import presets
from lamina.reference_py.atomic import write_text
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.network import memory


@pytest.fixture
def mounted(tmp_path):
    """Mounts a file system of a few bytes; only root of its own machine may."""
    places = []

    def mount(name: str, size: str = "64k"):
        place = tmp_path / name
        place.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "lamina", place], capture_output=True).returncode:
            pytest.skip("no right to mount a small file system")
        places.append(place)
        return place

    yield mount
    for place in places:
        subprocess.run(["umount", "-l", place], check=True)


def test_a_full_disk_keeps_what_was_there(mounted, registered_lamina):
    """Every kind of file that Lamina writes."""
    from lamina.addon.batch import task
    from lamina.addon.blend_files import save_copy
    from lamina.addon.rendering import images, oiio

    disk, noise = mounted("disk"), np.random.default_rng(1).random((120, 120)).astype(np.float32)
    channels = dict.fromkeys("RGBA", noise)

    def farmed(path, _):
        task._write(path, channels, {"lamina:pixels": task.pixel_hash(channels)})

    writers = {
        "a.exr": lambda path, _: images.write_exr(path, channels), "b.png": lambda path, _: images.write_png(path, np.frombuffer(noise.tobytes()[:57600], np.uint8).reshape(120, 160, 3)),
        "c.json": write_text, "d.blend": lambda path, _: save_copy(path), "e.exr": farmed,
    }  # fmt: skip
    for name, write in writers.items():
        (disk / name).write_bytes(b"the former file")
    filler = disk / "filler"
    filler.write_bytes(b"x" * 40_000)
    for name, write in writers.items():
        with pytest.raises((LaminaError, OSError)) as raised:
            write(disk / name, "text" * 20_000)
        assert "\n" not in str(raised.value).strip() and str(raised.value)
        assert (disk / name).read_bytes() == b"the former file"
    assert sorted(f.name for f in disk.iterdir()) == sorted([*writers, "filler"])
    filler.unlink()
    oiio.write(disk / "a.exr", {"R": noise[:8, :8]}, {})


def test_a_batch_on_a_full_disk_names_what_failed_and_goes_on_later(mounted, tmp_path, registered_lamina):
    disk = mounted("disk", "4k")
    job = tmp_path / "job.json"
    job.write_text(json.dumps({"stacks": ["clean_copper"], "tiers": ["weidlich_wilkie"], "backend": "nodes", "size": 16, "samples": 1}))
    _, said = lamina("batch", job, "-o", disk / "out", code=1)
    assert not list((disk / "out").glob("*.exr")), said
    subprocess.run(["mount", "-o", "remount,size=90m", disk], check=True)
    lamina("batch", job, "-o", disk / "out", "--no-sheet")
    assert len(list((disk / "out").glob("*.exr"))) == 1


def test_a_read_only_folder_is_named_before_work_starts(mounted, tmp_path):
    disk = mounted("disk")
    job = tmp_path / "job.json"
    job.write_text('{"stacks": ["clean_copper"]}')
    subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
    for command in (["batch", job, "-o", disk], ["batch", job, "-o", disk / "new"], ["farm", job, "-o", disk / "new"],
                    ["render", "clean_copper", "-o", disk / "a.png"]):  # fmt: skip
        _, said = lamina(*command, code=2)
        assert len(said.splitlines()) == 1 and str(disk) in said and "Read-only file system" in said


def test_a_bake_that_is_killed_leaves_a_cache_that_works(tmp_path):
    """Kill -9 at several moments of computing and writing; then the same bake succeeds, from a cache without broken files."""
    environment = os.environ | {"LAMINA_CACHE": str(tmp_path), "OMP_NUM_THREADS": "1"}
    command = [*RUN, "explain", "clean_copper", "--json"]
    for moment in (0.6, 1.4, 2.2):
        process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(moment)
        process.kill()
        process.wait()
        for file in tmp_path.glob("[!.]*.json"):
            json.loads(file.read_text())
    assert json.loads(subprocess.run(command, env=environment, capture_output=True, check=True).stdout)["chosen"]


@pytest.mark.parametrize("text", ["", "{", "null", "[1]", '{"chosen": 99}', '{"chosen": 0, "network": {"a": []}, "tried": [{}], "reason": 1}', "[" * 100_000, "\x00"])
def test_a_broken_cache_counts_as_none(tmp_path, monkeypatch, text):
    from lamina.reference_py.network import AutoNetwork

    monkeypatch.setattr(memory, "_memory", {})
    monkeypatch.setattr(memory, "_folder", tmp_path)
    stack = presets.load("clean_copper")
    memory._file(AutoNetwork.key(stack)).write_text(text)
    assert not AutoNetwork.is_known(stack)


def test_the_clock_may_run_backwards(tmp_path, monkeypatch):
    """The cache drops its oldest files by their dates: what was just written stays, whatever the clock says."""
    monkeypatch.setattr(memory, "_memory", {})
    monkeypatch.setattr(memory, "_folder", tmp_path)
    monkeypatch.setattr(memory, "_FILES", 2)
    for i, date in enumerate((4e9, 3e9)):
        memory.remembered(f"key {i}", lambda: i, lambda v: {"v": v}, lambda d: d["v"])
        os.utime(memory._file(f"key {i}"), (date, date))
    memory.remembered("now", lambda: 7, lambda v: {"v": v}, lambda d: d["v"])
    memory._memory.clear()
    assert memory.known("now", lambda d: d["v"]) == 7
