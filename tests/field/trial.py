# SPDX-License-Identifier: GPL-3.0-or-later
"""What a case does with one of the two materials: builds a scene, renders it, notes what it got beside what it expected."""

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import bpy
import numpy as np

from lamina.addon.blender.images import Exr, read_exr, write_exr
from lamina.addon.blender.versions import node_tree
from lamina.addon.check import check
from lamina.addon.material import material as materials
from lamina.addon.material.elements import node_of
from lamina.addon.rendering.geometry import sphere_mesh
from lamina.addon.rendering.settings import add_object, measurement_settings, render_to
from lamina.reference_py.material.schema import SCHEMA
from lamina.reference_py.material.stack import Stack

LAMINA, PRINCIPLED = "Lamina", "Principled"
SAME = 0.01  # the same picture: the same samples, and float32
LIVE = 0.05  # a shader that reads a value live beside a bake of it: each is within the tolerance of the tier auto, 2 %
WITHOUT_OSL = 0.05  # the stock branch beside the script: its tables' error, and the noise of other samples
_LONGEST = 240


@dataclass(frozen=True)
class Surface:
    """What the two materials are to show: a stack, and the sockets of a Principled node."""

    stack: Stack
    sockets: dict

    def with_color(self, color: tuple[float, float, float]) -> "Surface":
        data = self.stack.to_dict()
        data["base"]["color"] = list(color)
        return replace(self, stack=Stack.from_dict(data), sockets=self.sockets | {"Base Color": (*color, 1.0)})

    def with_roughness(self, roughness: float) -> "Surface":
        """With another roughness of what is on top."""
        data = self.stack.to_dict()
        (data["layers"] or [data["base"]])[0]["roughness"] = roughness
        return replace(self, stack=Stack.from_dict(data), sockets=self.sockets | {"Roughness": roughness})


def _surface(layers: list[dict], base: dict, **sockets) -> Surface:
    return Surface(Stack.from_dict({"layers": layers, "base": base}), {name.replace("_", " "): value for name, value in sockets.items()})


RED, BLUE, DARK = (0.6, 0.1, 0.05), (0.05, 0.2, 0.6), (0.03, 0.06, 0.1)
PAINT = _surface([{"kind": "dielectric", "roughness": 0.3}], {"kind": "lambert", "color": list(RED)}, Base_Color=(*RED, 1.0), Roughness=0.3)
GLAZE = _surface([{"kind": "dielectric", "roughness": 0.0}], {"kind": "lambert", "color": list(DARK)}, Base_Color=(*DARK, 1.0), Roughness=0.0)
METAL = _surface([], {"kind": "conductor", "reflectance": [0.9, 0.6, 0.3], "edge_color": [1.0, 1.0, 1.0], "roughness": 0.4},
                 Base_Color=(0.9, 0.6, 0.3, 1.0), Metallic=1.0, Roughness=0.4)  # fmt: skip
BRUSHED = _surface([], {"kind": "conductor", "reflectance": [0.9, 0.6, 0.3], "edge_color": [1.0, 1.0, 1.0], "roughness": 0.5, "anisotropy": 0.7},
                   Base_Color=(0.9, 0.6, 0.3, 1.0), Metallic=1.0, Roughness=0.5, Anisotropic=0.7)  # fmt: skip


@dataclass(frozen=True)
class Picture:
    """A render: every pass, and the pixels that the object covers."""

    exr: Exr
    layer: str

    def passed(self, name: str, components: str = "RGB") -> np.ndarray:
        """(h, w, n) of one pass."""
        return self.exr.layer(f"{self.layer}.{name}", components)

    @property
    def alpha(self) -> np.ndarray:
        return self.passed("Combined", "A")[..., 0]

    @property
    def covered(self) -> np.ndarray:
        return self.alpha > 0.99

    @property
    def pixels(self) -> np.ndarray:
        """(n, 3) of the covered pixels."""
        return self.passed("Combined")[self.covered]

    @property
    def mean(self) -> np.ndarray:
        """Mean color of the covered pixels."""
        return self.mean_of("Combined")

    def mean_of(self, name: str, components: str = "RGB") -> np.ndarray:
        return self.passed(name, components)[self.covered].mean(axis=0)

    @property
    def quarters(self) -> np.ndarray:
        """(4, 3) mean colors of the picture's quarters, so that a picture turned round is another one."""
        rgb = self.passed("Combined") * self.covered[..., None]
        h, w = (side // 2 for side in rgb.shape[:2])
        return np.array([part.mean(axis=(0, 1)) for part in (rgb[:h, :w], rgb[:h, w:], rgb[h:, :w], rgb[h:, w:])])


_PLAIN: dict[tuple[bool, str], Picture] = {}  # each is rendered once


class Trial:
    """One material of a case, in an empty file of factory settings. `stated` is what Check says of a loss by itself."""

    def __init__(self, kind: str, osl: bool):
        self.is_lamina, self.osl, self.stated = kind == LAMINA, osl, ""
        self._noted: list[tuple[bool, str]] = []

    def __enter__(self):
        self._folder = tempfile.TemporaryDirectory()
        self.folder = Path(self._folder.name)
        self.stage()
        return self

    def __exit__(self, *_):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self._folder.cleanup()

    # what was seen

    @property
    def is_wrong(self) -> bool:
        return not self._noted or any(not right for right, _ in self._noted)

    def text(self) -> str:
        """What was seen, what is wrong first."""
        told = [f"WRONG: {t}" for right, t in self._noted if not right] + [t for right, t in self._noted if right]
        line = "; ".join(told) or "WRONG: nothing was compared"
        return line if len(line) <= _LONGEST else line[: _LONGEST - 3] + "..."

    def require(self, what: str, is_so: bool) -> None:
        """Note a fact that has to be so."""
        self._noted.append((bool(is_so), what if is_so else f"not so: {what}"))

    def compare(self, what: str, got, expected, within: float = 0.02, least: float = 0.0) -> None:
        """Note numbers; every one may be off by `within` of the largest expected one, or of `least`."""
        got, expected = np.atleast_1d(np.asarray(got, float)), np.atleast_1d(np.asarray(expected, float))
        right = got.shape == expected.shape and bool(np.isfinite(got).all())
        off = np.abs(got - expected).max() / max(np.abs(expected).max(), least, 1e-9) if right else np.inf
        self._noted.append((right and off <= within, f"{what} {_short(got)} for {_short(expected)}"))

    def compare_pictures(self, what: str, got: Picture, expected: Picture, within: float = SAME) -> None:
        """Note two pictures: their quarters, and that neither is black."""
        off = np.abs(got.quarters - expected.quarters).max() / max(expected.quarters.max(), 1e-9)
        is_right = np.isfinite(got.quarters).all() and off <= within and expected.quarters.max() > 0.01
        means = (_short(picture.quarters.mean(axis=0)) for picture in (got, expected))
        self._noted.append((bool(is_right), f"{what} {' for '.join(means)} (off {100.0 * off:.1f} %)"))

    def broke(self, error: Exception) -> None:
        """Note that the case could not be done."""
        line = " ".join(str(error).split()) or "no reason given"
        self._noted.append((False, f"{type(error).__name__}: {line}"))

    def sound(self, material: bpy.types.Material, *allowed: str) -> None:
        """Note that Check finds nothing with the material but what `allowed` names by code, notes, and that OSL is off where it is."""
        if self.is_lamina:
            allowed = (*allowed, "without_osl") if not self.osl else allowed
            wrong = [f.text() for f in self.findings(material) if f.code not in allowed and f.level != check.NOTE]
            self.require(f"Check finds nothing {wrong or ''}".strip(), not wrong)

    def findings(self, material: bpy.types.Material) -> list[check.Finding]:
        return check.find(material, bpy.context.scene, bpy.context.preferences)

    def excuse(self, material: bpy.types.Material, code: str) -> None:
        """Take what Check finds under `code` as said to the artist."""
        if self.is_lamina and not self.stated:
            self.stated = next((f.text() for f in self.findings(material) if f.code == code), "")

    def excuse_textures(self, material: bpy.types.Material) -> None:
        """Without OSL the shader does not follow textures yet; that is said by Check or it is a fault."""
        if not self.osl:
            self.excuse(material, "texture_ignored")

    # scenes

    @property
    def within(self) -> float:
        """How far this scene's picture may be from one with OSL."""
        return SAME if self.osl or not self.is_lamina else WITHOUT_OSL

    def stage(self, size: int = 48, samples: int = 16, max_bounces: int = 2, *, furnace: bool = False) -> bpy.types.Scene:
        """An empty file with a camera that looks down at the origin, a sun and a grey world, or a white world alone (`furnace`)."""
        bpy.ops.wm.read_factory_settings(use_empty=True)
        scene = bpy.context.scene
        measurement_settings(scene, samples, size, max_bounces=max_bounces)
        scene.cycles.shading_system = self.osl
        scene.render.film_transparent = True
        scene.render.threads_mode, scene.render.threads = "FIXED", 1
        scene.world = bpy.data.worlds.new("World")
        background = next(n for n in node_tree(scene.world).nodes if n.type == "BACKGROUND")
        background.inputs["Color"].default_value = (1.0,) * 4 if furnace else (0.3, 0.3, 0.3, 1.0)
        camera = bpy.data.cameras.new("Camera")
        camera.type, camera.ortho_scale = "ORTHO", 2.4
        scene.camera = add_object(scene, "Camera", camera)
        scene.camera.location = (0.0, 0.0, 6.0)
        if not furnace:
            light = bpy.data.lights.new("Sun", "SUN")
            light.energy = 3.0
            add_object(scene, "Sun", light).rotation_euler = (0.5, 0.4, 0.0)
        return scene

    def material(self, surface: Surface = PAINT, name: str = "subject") -> bpy.types.Material:
        """A material that shows `surface`, finished."""
        material = bpy.data.materials.new(name)
        if self.is_lamina:
            materials.apply_stack(material, surface.stack)
            self.settle(material)
        else:
            node_tree(material)
            for name, value in surface.sockets.items():
                self.principled(material).inputs[name].default_value = value
        return material

    def settle(self, material: bpy.types.Material) -> None:
        """What a save does for a Lamina material."""
        if self.is_lamina:
            materials.refresh(material, settle=True)

    @staticmethod
    def principled(material: bpy.types.Material) -> bpy.types.ShaderNode:
        return next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED")

    def socket(self, material: bpy.types.Material, parameter: str) -> bpy.types.NodeSocket:
        """The socket of a base's "color", or of the top's "roughness", "coverage"."""
        if not self.is_lamina:
            return self.principled(material).inputs[{"color": "Base Color", "roughness": "Roughness", "coverage": "Coat Weight"}[parameter]]
        lamina = material.lamina
        element = lamina.base if parameter == "color" or not lamina.layers else lamina.layers[0]
        kind = SCHEMA.layers.get(element.kind) or SCHEMA.bases[element.kind]
        return node_of(element).inputs[kind.parameter(parameter).label]

    def set_color(self, material: bpy.types.Material, color) -> None:
        """What an artist does with the color, and what a save makes of it."""
        self.socket(material, "color").default_value = (*color, 1.0)
        self.settle(material)

    def shader_socket(self, material: bpy.types.Material) -> bpy.types.NodeSocket:
        """What feeds the surface."""
        return self.output(material).inputs["Surface"].links[0].from_socket

    @staticmethod
    def output(material: bpy.types.Material) -> bpy.types.ShaderNode:
        return material.node_tree.get_output_node("CYCLES")

    def is_same(self, what: str, material: bpy.types.Material, surface: Surface) -> None:
        """Note that the material's layers, or Principled's sockets, are those of `surface`."""
        if self.is_lamina:
            told = materials.stack_of(material).to_dict() if material.lamina.is_layered else {}
            wanted = surface.stack.to_dict()
            self.require(f"{what} has its layers", _numbers(told) == _numbers(wanted))
        else:
            node = self.principled(material)
            for name, value in surface.sockets.items():
                self.compare(f"{what}: {name}", node.inputs[name].default_value, value, 1e-5)

    def show(self, material: bpy.types.Material | None, mesh: bpy.types.ID | None = None, name: str = "item") -> bpy.types.Object:
        """A ball, or another mesh, of the material at the origin."""
        mesh = mesh or sphere_mesh("Ball", 64, 32)
        mesh.materials.clear()
        mesh.materials.append(material)
        item = add_object(bpy.context.scene, name, mesh)
        bpy.context.view_layer.objects.active = item
        item.select_set(True)
        return item

    def picture(self, scene: bpy.types.Scene | None = None, *, osl: bool | None = None) -> Picture:
        """Render. `osl` switches Open Shading Language for this picture alone; None leaves it as the scene has it."""
        scene = scene or bpy.context.scene
        former = scene.cycles.shading_system
        if osl is not None:
            scene.cycles.shading_system = osl
        try:
            render_to(scene, self.folder / "picture.exr")
        finally:
            scene.cycles.shading_system = former
        return Picture(read_exr(self.folder / "picture.exr"), scene.view_layers[0].name)

    def plain(self, surface: Surface = PAINT) -> Picture:
        """A ball of `surface` made anew in an empty file with OSL on: what all else is measured by. Leaves an empty stage."""
        key = self.is_lamina, repr(surface)
        if key not in _PLAIN:
            self.stage()
            self.show(self.material(surface))
            _PLAIN[key] = self.picture(osl=True)
        self.stage()
        return _PLAIN[key]


def image_of(path: Path, color) -> bpy.types.Image:
    """An image of one color, linear, and so exactly the surface's."""
    write_exr(path, {channel: np.full((8, 8), value) for channel, value in zip("RGB", color)})
    return bpy.data.images.load(str(path))


def _numbers(told: dict) -> str:
    """A stack without its names, rounded to what a socket holds."""

    def rounded(value):
        if isinstance(value, dict):
            return {k: rounded(v) for k, v in value.items() if k not in ("name", "source")}
        if isinstance(value, (list, tuple)):
            return [rounded(v) for v in value]
        return float(f"{value:.4g}") if isinstance(value, float) else value

    return repr(rounded(told))


def _short(values: np.ndarray) -> str:
    flat = np.asarray(values).ravel()
    return " ".join(f"{v:.3f}" for v in flat[:6]) + (" ..." if flat.size > 6 else "")
