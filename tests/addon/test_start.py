# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's start with the extension imports what registers, draws and listens, and nothing that computes."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("bpy")
pytestmark = pytest.mark.blender

DATA = Path(__file__).parents[1] / "data"
# As many as there are: who adds one raises this, and looks at the CPU time that `make start` prints.
MOST_MODULES = 72
# Stays unread until it is needed, as does all of numpy that Blender has not imported itself.
COMPUTES = (
    "reference_py.exchange.",
    "reference_py.fit.",
    "reference_py.lobes.",
    "reference_py.models.",
    "reference_py.optics.",
    "reference_py.registry",
    "addon.shader.",
)
ALLOWED = {"reference_py.lobes.cache", "reference_py.fit.readers"}
READ = """
import json, sys
import bpy
before = set(sys.modules)
import lamina
lamina.register()
def read():
    return sorted(name for name, module in sys.modules.items() if name not in before and type(module).__name__ != "_Unread")
started = read()
{then}
print("READ", json.dumps([started, read()]), flush=True)
import os; os._exit(0)
"""


def modules_read(then: str = "") -> list[list[str]]:
    """Names of the modules that were read by a start, and after `then` too."""
    done = subprocess.run([sys.executable, "-c", READ.format(then=then)], capture_output=True, text=True, timeout=120)
    line = next((line for line in done.stdout.splitlines() if line.startswith("READ ")), None)
    assert line, done.stdout + done.stderr
    return json.loads(line.removeprefix("READ "))


def test_a_start_reads_few_modules_and_none_that_compute():
    started, _ = modules_read()
    ours = [name.removeprefix("lamina.") for name in started if name.startswith("lamina.")]
    assert [name for name in started if name.split(".")[0] == "numpy"] == []
    assert [name for name in ours if name.startswith(COMPUTES) and name not in ALLOWED] == []
    assert len(ours) <= MOST_MODULES


# What Blender does with every file, also of people who use no Lamina in it, and when it quits.
WITHOUT_LAMINA = """
import tempfile
bpy.ops.wm.read_homefile(use_factory_startup=True)
bpy.data.materials.new("plain").diffuse_color = (1.0, 0.0, 0.0, 1.0)
bpy.context.view_layer.update()
bpy.ops.wm.save_as_mainfile(filepath=tempfile.mkdtemp() + "/plain.blend")
bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)
lamina.unregister()
"""


def test_a_file_without_lamina_reads_no_more():
    started, after = modules_read(WITHOUT_LAMINA)
    assert [name for name in after if name.startswith("lamina") and name not in started] == []


# What a click on a preset needs is there before it, once the panel was seen.
SEEN = """
from lamina.addon.later import read_soon
reads = 0
timer = read_soon()
while timer() is not None:
    reads += 1
assert 5 < reads < 60, reads
seen = read()
bpy.ops.wm.read_homefile(use_factory_startup=True)
assert bpy.ops.lamina.apply_preset(preset="satin_varnish") == {"FINISHED"}
started = seen
"""


def test_a_first_click_after_the_panel_was_seen_reads_little():
    seen, after = modules_read(SEEN)
    missing = [name for name in after if name.startswith("lamina") and name not in seen]
    assert len(missing) < 10, missing


def test_a_property_is_followed_though_nothing_was_read_before():
    """Properties call what makes shaders, which is imported with the first that is set."""
    then = f"""
bpy.ops.wm.open_mainfile(filepath={str(DATA / "schema_4.blend")!r})
material = next(m for m in bpy.data.materials if m.lamina.is_layered and m.lamina.layers)
assert "lamina.addon.material.material" not in read()
material.lamina.stamp = ""
material.lamina.layers[0].visible = False
assert material.lamina.problem == "" and material.lamina.stamp, "not followed"
"""
    started, after = modules_read(then)
    assert "lamina.addon.material.material" in set(after) - set(started)
