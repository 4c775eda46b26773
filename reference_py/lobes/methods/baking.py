# SPDX-License-Identifier: GPL-3.0-or-later
"""Method `baked`: the truth of a stack, fitted by few closures. Stacks of equal content share one bake.

Live values are followed by tables over them too (`baked.follows`).
"""

from ...material.place import Place, in_words
from ...material.qualities import BAKED
from ...material.schema import ANISOTROPY, SCATTERING, THIN_FILM
from ...material.stack import Stack
from ...optics.optical_stack import Support
from ..baked import DEFAULT_GLOSSY, baked, follows, pack_lobes, unpack_lobes
from ..bare_base import is_bare_brushed, is_bare_oren_nayar
from ..cache import stack_key
from ..made import Made, Options
from .featured_analytic import featured_analytic
from .method import Computed, Method

NAME = BAKED


def _is_own(stack: Stack, live: tuple[Place, ...]) -> bool:
    """Whether Cycles' closures of the base itself are as good as a bake."""
    return is_bare_oren_nayar(stack) or (is_bare_brushed(stack) and not live)


def _follows(stack: Stack, live: tuple[Place, ...]) -> bool:
    return is_bare_oren_nayar(stack) or follows(stack, live)


def _glossy(options: Options) -> int:
    return options.glossy or DEFAULT_GLOSSY


def _make(stack: Stack, options: Options) -> Made:
    if _is_own(stack, options.live):
        lobe_set = featured_analytic(stack)
        return Made(NAME, stack, lobe_set, "the base's own closures, " + ("right within 1 %" if is_bare_brushed(stack) else "which are exact"))
    lobe_set = COMPUTED.result(stack, options).with_values_of(stack)
    return Made(NAME, stack, lobe_set, f"baked, {_glossy(options)} glossy" + (f", over {in_words(options.live)}" if options.live else ""))


COMPUTED = Computed(
    compute=lambda stack, options: baked(stack, options.live, _glossy(options), options.progress),
    key=lambda stack, options: f"baked {stack_key(stack, options.live)} {_glossy(options)}",
    pack=pack_lobes,
    unpack=unpack_lobes,
    is_instant=lambda stack, options: _is_own(stack, options.live) or not _follows(stack, options.live),
    most_glossy=DEFAULT_GLOSSY,
)

METHOD = Method(
    NAME,
    _make,
    _follows,
    COMPUTED,
    Support(features=(ANISOTROPY, THIN_FILM, SCATTERING)),
)
