# SPDX-License-Identifier: GPL-3.0-or-later
# What the findings share: sourced by them, not run. A finding writes its measurement as $work/measure.py and calls `blenders VERSION...`
# or `packages NAME==VERSION...`.
#   PYTHON311, PYTHON313   the interpreters; otherwise python3.11 and python3.13 of the PATH
# Exit status: 0 the behaviour is still the one described, 1 it changed, 2 it could not be measured here.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() { echo "$(basename "$0"): $*" >&2; exit 2; }

# The Python that the wheel of this Blender needs. It is run, because a command of that name may be a shim of another version.
python_of() {
    local wanted=3.13 named=${PYTHON313:-python3.13}
    case $1 in 4.5.* | 5.0.*) wanted=3.11 named=${PYTHON311:-python3.11} ;; esac
    "$named" -c 'import sys, venv, ensurepip; sys.exit("%d.%d" % sys.version_info[:2] != sys.argv[1])' "$wanted" 2>/dev/null ||
        fail "bpy $1 needs Python $wanted with venv: put python$wanted on the PATH, or name one in PYTHON${wanted/./}"
    echo "$named"
}

# A virtual environment with this bpy in $work/VERSION.
install_bpy() {
    local numpy=2.5.5
    case $1 in 4.5.* | 5.0.*) numpy=1.26.4 ;; esac
    "$2" -m venv "$work/$1" || fail "no virtual environment for bpy $1"
    "$work/$1/bin/python" -m pip install --quiet --disable-pip-version-check --only-binary :all: "bpy==$1" "numpy==$numpy" ||
        fail "pip could not install bpy $1 (its message is above)"
}

blenders() {
    local version python result=0 rc
    for version; do python=$(python_of "$version"); done
    for version; do
        python=$(python_of "$version")
        install_bpy "$version" "$python"
        echo "Blender $version"
        rc=0
        (cd "$work" && "$work/$version/bin/python" measure.py) || rc=$?
        case $rc in 0) ;; 3) result=1 ;; *) fail "the measurement stopped in bpy $version (status $rc)" ;; esac
    done
    exit "$result"
}

# Runs measure.py with these packages, NAME==VERSION, and no Blender.
packages() {
    local python rc=0
    python=$(python_of 4.5.15)
    "$python" -m venv "$work/packages" || fail "no virtual environment"
    "$work/packages/bin/python" -m pip install --quiet --disable-pip-version-check --only-binary :all: "$@" || fail "pip could not install $* (its message is above)"
    (cd "$work" && "$work/packages/bin/python" measure.py) || rc=$?
    case $rc in 0) exit 0 ;; 3) exit 1 ;; *) fail "the measurement stopped (status $rc)" ;; esac
}

cat >"$work/blender.py" <<'PYTHON'
"""Scenes, renders and comparisons for the findings; imports nothing but Blender and numpy."""
import atexit
import contextlib
import os
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

VERSION = bpy.app.version[:2]
FOLDER = Path(tempfile.mkdtemp(dir=Path(__file__).parent))
_changed = []

# The wheel keeps oslquery where Python does not look. Without it a Script node gets no sockets.
sys.path.append(str(Path(bpy.utils.resource_path("LOCAL"), "python", "lib", "python%d.%d" % sys.version_info[:2], "site-packages")))


def told(label, value, expected, tolerance=0.0):
    """Print one figure, and keep in mind whether it is still the expected one."""
    if isinstance(expected, (float, tuple, list, np.ndarray)):
        same = np.shape(value) == np.shape(expected) and bool(np.all(np.abs(np.subtract(value, expected)) <= tolerance))
        shown = " ".join(f"{number:.6g}" for number in np.ravel(value))
    else:
        same, shown = value == expected, value
    print(f"  {label}: {shown}" + ("" if same else f"    CHANGED, expected {expected} within {tolerance}"), flush=True)
    if not same:
        _changed.append(label)


def done():
    sys.stdout.flush()
    os._exit(3 if _changed else 0)  # at its end the wheel prints tracebacks of its own that mean nothing


@contextlib.contextmanager
def silent():
    """Blender's own progress on file descriptor 1 goes nowhere."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept), os.close(nowhere)


def empty_file(osl=False):
    """A file with nothing but a scene that Cycles renders on the CPU under a black world."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.device, scene.cycles.shading_system = "CYCLES", "CPU", osl
    scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = 16, False, False
    scene.cycles.blur_glossy = 0.0
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    world((0.0, 0.0, 0.0))
    return scene


def world(color):
    made = bpy.data.worlds.new("World")
    background = nodes_of(made).new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (*color, 1.0)
    output = made.node_tree.nodes.new("ShaderNodeOutputWorld")
    made.node_tree.links.new(background.outputs[0], output.inputs["Surface"])
    bpy.context.scene.world = made


def nodes_of(owner):
    """The emptied nodes of a material or world."""
    if owner.node_tree is None:
        owner.use_nodes = True
    owner.node_tree.nodes.clear()
    return owner.node_tree.nodes


def material(name, type=None, **values):
    """A material of one shader node with these values of its sockets (_ for a space), and that node."""
    made = bpy.data.materials.new(name)
    nodes = nodes_of(made)
    output = nodes.new("ShaderNodeOutputMaterial")
    if type is None:
        return made, output
    node = nodes.new(type)
    for socket, value in values.items():
        node.inputs[socket.replace("_", " ")].default_value = value
    made.node_tree.links.new(node.outputs[0], output.inputs["Surface"])
    return made, node


def script_node(tree, source, name="script"):
    """An OSL Script node of this source. The scene's engine must be Cycles, or it gets no sockets."""
    import cycles.osl

    text = bpy.data.texts.new(name + ".osl")
    text.from_string(source)
    node = tree.nodes.new("ShaderNodeScript")
    node.script = text
    with silent():
        cycles.osl.update_script_node(node, lambda kind, message: print(message, file=sys.stderr))
    if not node.outputs:
        raise RuntimeError("the Script node has no sockets")
    return node


def plane(shown_material, theta_deg=0.0):
    """A plane that fills the picture, seen by an orthographic camera from theta_deg off its normal."""
    mesh = bpy.data.meshes.new("plane")
    mesh.from_pydata([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], [], [(0, 1, 2, 3)])
    mesh.materials.append(shown_material)
    shown = bpy.data.objects.new("plane", mesh)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 0.1
    theta = np.radians(theta_deg)
    camera.location, camera.rotation_euler = (5 * np.sin(theta), 0, 5 * np.cos(theta)), (0, theta, 0)
    for each in (shown, camera):
        bpy.context.scene.collection.objects.link(each)
    bpy.context.scene.camera = camera
    return shown


def render():
    """The picture, (h, w, 4), as Cycles computed it."""
    path = FOLDER / "picture.exr"
    bpy.context.scene.render.filepath = str(path)
    with silent():
        bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.is_data = True
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    shape = (image.size[1], image.size[0], 4)
    bpy.data.images.remove(image)
    return pixels.reshape(shape).astype(float)


def seen():
    """The picture's mean color, (3,)."""
    return render()[..., :3].mean((0, 1))
PYTHON
