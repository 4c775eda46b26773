# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface of a layer or the base in a live shader: its normal, tangent and widths, by its features."""

from dataclasses import dataclass, replace

from ....reference_py.lobes.lobe import DARK
from ....reference_py.lobes.view_table import MIN_COS_O
from ....reference_py.material.schema import ANISOTROPY, NORMAL, THIN_FILM
from ....reference_py.material.stack import Element
from .block import Closure
from .parts import fill, narrow


@dataclass(frozen=True)
class Surface:
    """Expressions, and the functions and statements that they need."""

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


def view(suffix: str = "", normal: str = "N") -> str:
    """The statements that declare `bent_normal` and `view_z`; they call `bent.h`."""
    return fill("view.osl", SUFFIX=suffix, NORMAL=normal, MIN_COS_O=f"{MIN_COS_O:g}")


def surface_of(element: Element, owner: str) -> Surface:
    """The surface of an element whose shader parameters begin with `owner`; without widths where it is diffuse."""
    suffix, normal = (f"_{owner}", f"normal_{owner}") if element.has(NORMAL) else ("", "N")
    common = [fill("own_normal.osl", OWNER=owner)] if element.has(NORMAL) else []
    common.append(view(suffix, normal))
    if "roughness" not in element:
        return Surface((fill("bent.h"),), tuple(common), normal, f"view_z{suffix}", "", "", "", "")
    if element.has(ANISOTROPY):
        common.append(fill("surface_anisotropic.osl", OWNER=owner, NORMAL=normal))
        functions, tangent = (fill("bent.h"), narrow(), fill("turned.h")), f"tangent_{owner}"
        widths = f"alpha_x_{owner}", f"alpha_y_{owner}"
    else:
        common += [fill("surface_tangent.osl", SUFFIX=suffix, NORMAL=normal), fill("surface.osl", OWNER=owner)]
        functions, tangent = (fill("bent.h"), narrow()), f"tangent{suffix}"
        widths = f"alpha_{owner}", f"across(alpha_{owner})"
    return Surface(functions, tuple(common), normal, f"view_z{suffix}", tangent, f"alpha_{owner}", *widths)


def top_closure(surface: Surface, element: Element, owner: str) -> str:
    """The closure of an interface below vacuum; it calls `top_function`. Of a closure's curves one knows films."""
    ior, kind = f"{owner}Ior", element["distribution"]
    shape = f'{surface.frame}, {surface.alpha_x}, {surface.alpha_y}, {ior}, "{kind}"'
    film = f", {owner}FilmThickness, {owner}FilmIor" if element.has(THIN_FILM) else ""
    return f"{'filmed_' if film else ''}interface_bsdf({shape}{film})"


def top_function(element: Element) -> str:
    """The function that the closure of an interface below vacuum calls."""
    return fill("filmed_interface.h" if element.has(THIN_FILM) else "interface.h")


@dataclass(frozen=True)
class BaseClosures:
    """The closures of a base, and the functions and the statements at the shader's top that they need."""

    closures: tuple[Closure, ...]
    functions: tuple[str, ...] = ()
    common: tuple[str, ...] = ()

    def below(self, weight: str) -> "BaseClosures":
        """The closures under layers that leave `weight` of them."""
        return replace(self, closures=tuple(replace(c, weight=f"{weight} * {c.weight}") for c in self.closures))


def diffuse_closures(base: Element, surface: Surface) -> BaseClosures:
    """Those of a diffuse base: of a rough one two, as its color counts otherwise from Blender 5.3 on (osl/oren_nayar_shares.h)."""
    if base.kind == "lambert":
        return BaseClosures((Closure("BaseColor", f"diffuse({surface.normal})"),))
    white, dark = (
        Closure(weight, f"oren_nayar_diffuse_bsdf({surface.normal}, color({color:g}), base_sigma)")
        for weight, color in (("white_base", 1.0), (f"(BaseColor - white_base) * {1.0 / DARK:g}", DARK))
    )
    return BaseClosures((white, dark), (fill("oren_nayar_shares.h"),), (fill("oren_nayar_sigma.osl"),))
