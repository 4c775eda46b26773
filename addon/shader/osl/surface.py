# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface of a layer or the base in a live shader: its normal, tangent and widths, by its features."""

from dataclasses import dataclass, replace

from ....reference_py.lobes.lobe import DARK
from ....reference_py.material.schema import ANISOTROPY, NORMAL, THIN_FILM
from ....reference_py.material.stack import Base, Layer, Stack
from ....reference_py.optics.bases import ConductorBase
from ....reference_py.optics.optical_stack import OpticalStack
from .block import Closure
from .view_frame import Frame


@dataclass(frozen=True)
class Surface:
    """Expressions, and the files and statements that they need."""

    functions: tuple[str, ...]
    common: tuple[str, ...]
    normal: str
    view: str
    """Cosine of the view and the normal, as Cycles bends it."""
    tangent: str
    alpha: str
    """That of the isotropic surface that stands for it where only energies count."""
    alpha_x: str
    alpha_y: str

    @property
    def frame(self) -> str:
        return f"{self.normal}, {self.tangent}"

    def microfacet(self, distribution: str) -> str:
        """The closure without a Fresnel curve."""
        return f'microfacet("{distribution}", {self.frame}, {self.alpha_x}, {self.alpha_y}, 1.0, 0)'


def surface_of(element: Layer | Base, owner: str) -> Surface:
    """The surface of an element whose shader parameters begin with `owner`; without widths where it is diffuse."""
    frame = Frame(owner if element.has(NORMAL) else "")
    suffix, normal, common = frame.suffix, frame.normal, [*frame.view]
    functions: tuple[str, ...] = (*frame.functions, "bent.h")
    if "roughness" not in element:
        return Surface(functions, tuple(common), normal, f"view_z{suffix}", "", "", "", "")
    alpha = f"alpha_{owner}"
    if element.has(ANISOTROPY):
        tangent, functions = f"tangent_{owner}", (*functions, "anisotropic_roughness.h", "rotate_tangent.h")
        widths = f"alpha_x_{owner}", f"alpha_y_{owner}"
        common += [f"float {name};" for name in (*widths, alpha)]
        common.append(f"anisotropic_alphas({owner}Roughness, {owner}Anisotropy, {', '.join(widths)}, {alpha});")
        common.append(f"vector {tangent} = rotate_tangent(Tangent, {normal}, {owner}Rotation);")
    else:
        tangent, functions = f"tangent{suffix}", (*functions, "roughness.h", "break_isotropy.h", "tangent.h")
        widths = alpha, f"break_isotropy({alpha})"
        common += [f"vector {tangent} = any_tangent({normal});", f"float {alpha} = alpha_from_roughness({owner}Roughness);"]
    return Surface(functions, tuple(common), normal, f"view_z{suffix}", tangent, alpha, *widths)


def beckmann(element: Layer | Base) -> str:
    return "1" if element["distribution"] == "beckmann" else "0"


def top_closure(surface: Surface, element: Layer | Base, owner: str) -> str:
    """The closure of an interface below vacuum; it calls `top_function`. Of a closure's curves one knows films."""
    ior, distribution = f"{owner}Ior", element["distribution"]
    shape = f'{surface.frame}, {surface.alpha_x}, {surface.alpha_y}, {ior}, "{distribution}"'
    film = f", {owner}FilmThickness, {owner}FilmIor" if element.has(THIN_FILM) else ""
    return f"{'filmed_' if film else ''}interface_bsdf({shape}{film})"


def top_function(element: Layer | Base) -> str:
    """The file that the closure of an interface below vacuum calls."""
    return "filmed_interface.h" if element.has(THIN_FILM) else "interface.h"


@dataclass(frozen=True)
class BaseClosures:
    """The closures of a base, and the files and the statements at the shader's top that they need."""

    closures: tuple[Closure, ...]
    functions: tuple[str, ...] = ()
    common: tuple[str, ...] = ()

    def below(self, weight: str) -> "BaseClosures":
        """The closures under layers that leave `weight` of them."""
        return replace(self, closures=tuple(replace(c, weight=f"{weight} * {c.weight}") for c in self.closures))


def is_metal(stack: Stack) -> bool:
    """Whether the base is a metal; else it is diffuse, as no method that is written here knows others."""
    return isinstance(OpticalStack.of(stack).base, ConductorBase)


def is_rough(base: Base) -> bool:
    """Whether a diffuse base has inclined facets, by its structure."""
    return "sigma_deg" in base


def base_name(owner: str, value: str) -> str:
    """The variable that holds a value of a base whose shader parameters begin with `owner`: "base_sigma"."""
    return f"{owner.lower()}_{value}"


def diffuse_closures(base: Base, surface: Surface, owner: str) -> BaseClosures:
    """Those of a diffuse base whose shader parameters begin with `owner`: of a rough one two, as its color counts otherwise from Blender 5.3 on (osl/oren_nayar.h)."""
    if not is_rough(base):
        return BaseClosures((Closure(f"{owner}Color", f"diffuse({surface.normal})"),))
    sigma, white_color = base_name(owner, "sigma"), f"white_{owner.lower()}"
    white, dark = (
        Closure(weight, f"oren_nayar_diffuse_bsdf({surface.normal}, color({color:g}), {sigma})", shape=(f"{owner}SigmaDeg",))
        for weight, color in ((white_color, 1.0), (f"({owner}Color - {white_color}) * {1.0 / DARK:g}", DARK))
    )
    common = f"float {sigma} = oren_nayar_sigma({owner}SigmaDeg);", f"color {white_color} = oren_nayar_white({owner}Color, {sigma});"
    return BaseClosures((white, dark), ("oren_nayar.h",), common)


def metal_closure(base: Base, owner: str, closure: Closure) -> BaseClosures:
    """That of a metal base, and the statements that declare its index: `base_name` of "eta" and "k"."""
    eta, k = base_name(owner, "eta"), base_name(owner, "k")
    if "reflectance" in base:
        common = f"color {eta};", f"color {k};", f"artist_index({owner}Reflectance, {owner}EdgeColor, {eta}, {k});"
        return BaseClosures((closure,), ("artist_index.h",), common)
    return BaseClosures((closure,), (), (f"color {eta} = (color){owner}Eta;", f"color {k} = (color){owner}K;"))
