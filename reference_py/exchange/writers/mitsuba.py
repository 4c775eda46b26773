# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of Mitsuba 3: a sphere of RGL's table in the sun, and a stack as explicit slabs under a white sky.

The sphere is that of `lamina render --scene sphere`: seen along z by parallel rays, in a sun of irradiance pi. The slabs are planes one unit apart,
which light meets as the models say of `surface=single`; radiance is the albedo at the angle `theta`: `mitsuba slabs.xml -D theta=60`.
"""

from collections.abc import Sequence
from xml.etree import ElementTree

import numpy as np

from ...errors import LaminaError
from ...material.coverage import is_plain
from ...material.schema import ANISOTROPY, SCATTERING
from ...material.stack import Stack
from ...optics.bases import ConductorBase, DiffuseBase
from ...optics.interface import Interface, Microfacets
from ...optics.optical_stack import OpticalStack, supports

SUN_THETA_DEG = 45.0
# Half width of the slabs, and of what is seen of them from the distance.
_WIDE, _SEEN, _DISTANCE = 2000.0, 0.1, 100.0


@supports("scene", distributions=None, features=(ANISOTROPY, SCATTERING))
class Slabs:
    """What Mitsuba's planes and media can be."""

    name = "mitsuba"


def measured_scene(name: str, table: str) -> str:
    """A scene with the file of a table, which stands beside it. `name` is a comment."""
    root = _root(name, spp=64, size=256)
    _plugin(root, "integrator", "path", max_depth=2)
    sine, cosine = np.sin(np.radians(SUN_THETA_DEG)), np.cos(np.radians(SUN_THETA_DEG))
    sun = _plugin(root, "emitter", "directional")
    ElementTree.SubElement(sun, "vector", name="direction", value=_numbers((-sine, 0.0, -cosine)))
    _color(sun, "irradiance", (np.pi,))
    _camera(root, ("lookat", {"origin": "0, 0, 10", "target": "0, 0, 0", "up": "0, 1, 0"}))
    surface = _plugin(root, "bsdf", "measured", id="surface")
    ElementTree.SubElement(surface, "string", name="filename", value=table)
    ElementTree.SubElement(_plugin(root, "shape", "sphere"), "ref", id="surface")
    return _text(root)


def slab_scene(stack: Stack) -> str:
    """A stack as planes. Raises LaminaError for what Mitsuba has not: films, coverage, rough diffuse bases."""
    if not is_plain(stack):
        raise LaminaError("slabs cover the whole surface: choose a stack without coverage and opaque layers, or a table")
    optics = OpticalStack.of(stack, Slabs)
    if isinstance(optics.base, DiffuseBase) and optics.base.sigma_deg > 0.0:
        raise LaminaError("Mitsuba has no rough diffuse base of this model: choose a Lambert base, or a table")
    root, top = _root(stack.name, theta=0, spp=64, size=64), len(optics.interfaces)
    # `volpath` follows one channel's distances: where channels differ, few paths carry most of another's light
    is_grey = all(np.ptp(interface.tau) == 0.0 for interface in optics.interfaces)
    _plugin(root, "integrator", "volpath" if is_grey else "volpathmis", max_depth=-1, rr_depth=30)
    _color(_plugin(root, "emitter", "constant"), "radiance", (1.0,))
    _camera(
        root,
        ("scale", {"x": str(_SEEN), "y": str(_SEEN)}),
        ("lookat", {"origin": f"0, 0, {_DISTANCE}", "target": "0, 0, 0", "up": "0, 1, 0"}),
        ("rotate", {"y": "1", "angle": "$theta"}),
        ("translate", {"z": str(top)}),
    )
    media = [_medium(root, f"medium_{i}", interface) for i, interface in enumerate(optics.interfaces)]
    for i, interface in enumerate(optics.interfaces):
        _interface(_plane(root, f"interface_{i}", top - i, interface.facets, media[i - 1] if i else None, media[i]), interface)
    _base(_plane(root, "base", 0, optics.base.facets, media[-1] if media else None, None), optics.base)
    return _text(root)


def _root(comment: str, **defaults) -> ElementTree.Element:
    root = ElementTree.Element("scene", version="3.0.0")
    root.append(ElementTree.Comment(f" {comment.replace('--', '- -')} "))
    for name, value in defaults.items():
        ElementTree.SubElement(root, "default", name=name, value=str(value))
    return root


def _plugin(parent, kind: str, type: str, id: str | None = None, **integers: int) -> ElementTree.Element:
    plugin = ElementTree.SubElement(parent, kind, type=type, **({"id": id} if id else {}))
    for name, value in integers.items():
        ElementTree.SubElement(plugin, "integer", name=name, value=str(value))
    return plugin


def _camera(root, *steps: tuple[str, dict[str, str]]) -> None:
    sensor = _plugin(root, "sensor", "orthographic")
    to_world = ElementTree.SubElement(sensor, "transform", name="to_world")
    for step, values in steps:
        ElementTree.SubElement(to_world, step, **values)
    film = _plugin(sensor, "film", "hdrfilm")
    for name in ("width", "height"):
        ElementTree.SubElement(film, "integer", name=name, value="$size")
    ElementTree.SubElement(film, "string", name="pixel_format", value="rgb")
    _plugin(film, "rfilter", "box")
    ElementTree.SubElement(_plugin(sensor, "sampler", "independent"), "integer", name="sample_count", value="$spp")


def _plane(root, id: str, height: float, facets: Microfacets | None, above: str | None, below: str | None) -> ElementTree.Element:
    """A plane that faces up, its tangent along the facets' own x."""
    plane = _plugin(root, "shape", "rectangle", id)
    to_world = ElementTree.SubElement(plane, "transform", name="to_world")
    ElementTree.SubElement(to_world, "scale", value=str(_WIDE))
    if facets is not None and facets.anisotropic is not None:
        ElementTree.SubElement(to_world, "rotate", z="1", angle=repr(float(np.degrees(facets.anisotropic.angle))))
    ElementTree.SubElement(to_world, "translate", z=str(height))
    for side, medium in (("exterior", above), ("interior", below)):
        if medium:
            ElementTree.SubElement(plane, "ref", name=side, id=medium)
    return plane


def _medium(root, id: str, interface: Interface) -> str | None:
    """The medium below an interface, by its id; None where it does nothing."""
    depth = interface.tau
    if not np.any(depth):
        return None
    medium = _plugin(root, "medium", "homogeneous", id)
    _float(medium, "scale", np.max(depth))
    _color(medium, "sigma_t", depth / np.max(depth))
    albedo, g = (np.zeros(3), 0.0) if interface.scattering is None else (interface.scattering.albedo, interface.scattering.g)
    _color(medium, "albedo", albedo)
    _float(_plugin(medium, "phase", "hg"), "g", g)
    return id


def _interface(plane, interface: Interface) -> None:
    if interface.eta == 1.0:
        _plugin(plane, "bsdf", "null")
        return
    bsdf = _plugin(plane, "bsdf", "dielectric" if interface.facets.is_specular else "roughdielectric")
    _float(bsdf, "int_ior", interface.n_below)
    _float(bsdf, "ext_ior", interface.n_above)
    _facets(bsdf, interface.facets)


def _base(plane, base: DiffuseBase | ConductorBase) -> None:
    if isinstance(base, DiffuseBase):
        _color(_plugin(plane, "bsdf", "diffuse"), "reflectance", base.color)
        return
    bsdf = _plugin(plane, "bsdf", "conductor" if base.is_specular else "roughconductor")
    for name, values in zip(("eta", "k"), base.relative_index):
        _color(bsdf, name, values)
    _facets(bsdf, base.facets)


def _facets(bsdf, facets: Microfacets) -> None:
    if facets.is_specular:
        return
    ElementTree.SubElement(bsdf, "string", name="distribution", value=facets.distribution)
    if facets.anisotropic is None:
        _float(bsdf, "alpha", facets.alpha)
        return
    _float(bsdf, "alpha_u", facets.anisotropic.alpha_x)
    _float(bsdf, "alpha_v", facets.anisotropic.alpha_y)


def _float(parent, name: str, value: float) -> None:
    ElementTree.SubElement(parent, "float", name=name, value=repr(float(value)))


def _color(parent, name: str, values: Sequence[float]) -> None:
    ElementTree.SubElement(parent, "rgb", name=name, value=_numbers(values))


def _numbers(values: Sequence[float]) -> str:
    return ", ".join(repr(float(value)) for value in values)


def _text(root) -> str:
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"
