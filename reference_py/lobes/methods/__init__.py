# SPDX-License-Identifier: GPL-3.0-or-later
"""Methods: how a stack becomes a lobe set. `METHODS` has one row for each; users see them as qualities.

`closure_model` evaluates a lobe set exactly as Cycles does, and `addon.shader` writes it as a shader.
"""

from dataclasses import replace

from ...errors import LaminaError
from ...material.coverage import Patch, is_plain, patches
from ...material.place import Place, named
from ...material.qualities import DEFAULT_METHOD
from ...material.stack import Stack
from ...optics.optical_stack import OpticalStack
from ..analytic import AnalyticLobes
from ..analytic.interface_tables import closure_energy
from ..baked import follows as can_follow
from ..baked import in_tables
from ..bare_base import is_bare_oren_nayar
from ..brushing import without_idle
from ..cache import ALWAYS_LIVE
from ..made import LobeSet, Made, Options
from ..patch_lobes import PatchLobes
from ..pools import MAX_CLOSURES
from . import auto, baking
from .featured_analytic import featured_analytic
from .method import Method
from .not_bakeable import bakeable, beyond_bakes, has_film, needs_live, not_bakeable, scatters
from .paper import PaperLobes

METHODS = {
    row.name: row
    for row in (
        Method(
            PaperLobes.name,
            lambda stack, options: Made(PaperLobes.name, stack, PaperLobes(stack)),
            lambda stack, live: True,
        ),
        Method(
            AnalyticLobes.name,
            lambda stack, options: Made(AnalyticLobes.name, stack, featured_analytic(stack)),
            lambda stack, live: True,
        ),
        baking.METHOD,
        auto.METHOD,
    )
}


def method_of(name: str) -> Method:
    """The row of a method. Raises LaminaError on an unknown name."""
    if name not in METHODS:
        raise LaminaError("unknown quality {name!r}; choose {choices}", name=name, choices=", ".join(METHODS))
    return METHODS[name]


def holds_values(name: str) -> bool:
    """Whether shaders of a method hold a stack's values and not only its structure, so that they have to be computed."""
    return method_of(name).computed is not None


def _row_of(method: str, stack: Stack) -> Method:
    """The row of a method for a stack: that which chooses leaves many patches to the bake, as lobes of live ones share no pool."""
    row = method_of(method)
    return baking.METHOD if row is auto.METHOD and len(patches(stack)) >= MAX_CLOSURES else row


def make_lobe_set(stack: Stack, method: str = DEFAULT_METHOD, **options) -> Made:
    """The lobe set of a stack; `options` are those of `Options`.

    Raises LaminaError on an unknown method, what it does not support, too many covered layers, and a live value of no layer.
    """
    row, asked = _row_of(method, stack), Options(**options)
    parts = _parts(row, stack, asked)
    made = []
    for done, (patch, own) in enumerate(parts):
        if asked.progress is not None:
            own = Options(own.live, own.tolerance, own.glossy, lambda share, done=done: asked.report((done + share) / len(parts)))
        made.append((patch, _made(row, patch.stack, own)))
    # live lobe sets have sockets of what rests, too, which a user may give a value
    made = [(whole, _with_idle(own, whole.stack) if own.lobe_set.is_live and whole != patch else own) for whole, (patch, own) in zip(patches(stack), made)]
    if is_plain(stack):
        return made[0][1]
    reasons = dict.fromkeys(part.reason for _, part in made if part.reason)
    return Made(method, stack, PatchLobes(stack, tuple(made), closure_energy), "; ".join(reasons))


def provisional(stack: Stack) -> Made:
    """What stands in for a method that takes time until it is there: `analytic`, or the quickest bake of media that scatter, which that does not know."""
    made = make_lobe_set(stack, baking.NAME, glossy=1) if scatters(stack) else make_lobe_set(stack, AnalyticLobes.name)
    return replace(made, stands_in=True)


def key_of(stack: Stack, method: str, **options) -> str:
    """What the lobe set of a method that computes first is kept by; coverages do not matter."""
    row = _row_of(method, stack)
    return "\n".join(row.computed.key(bakeable(patch.stack), own) for patch, own in _parts(row, stack, Options(**options)))


def followed_by_nodes(stack: Stack, method: str, live: tuple[Place, ...]) -> tuple[Place, ...]:
    """Those of the live values that a method's stock nodes follow, in every patch that has them."""
    lost = {place for patch in patches(stack) for place in _lost(patch, method, live)}
    return tuple(place for place in live if place not in lost)


def _lost(patch: Patch, method: str, live: tuple[Place, ...]) -> list[Place]:
    """Those of the live values of the whole stack that the stock nodes of a patch, which has them, do not follow."""
    own = {place: there for place in live if (there := patch.place(place)) is not None}
    followed = _followed(patch.stack, method, tuple(own.values()))
    return [place for place, there in own.items() if there not in followed]


def _followed(stack: Stack, method: str, live: tuple[Place, ...]) -> tuple[Place, ...]:
    """Those of the live values of a plain stack that its stock nodes follow, and those that have no effect."""
    if is_bare_oren_nayar(stack):
        return live
    if not holds_values(method):
        return ()
    told, moving = without_idle(stack, live)
    resting = tuple(place for place in live if place not in moving)
    return resting if not_bakeable(told) else (*resting, *in_tables(told, moving))


def is_cached(stack: Stack, method: str, **options) -> bool:
    """Whether making the lobe set takes no time."""
    row = _row_of(method, stack)
    return row.computed is None or all(row.computed.is_cached(bakeable(patch.stack), own) for patch, own in _parts(row, stack, Options(**options)))


def packed(stack: Stack, method: str, **options) -> list[dict]:
    """What a method computes for each patch of a stack, as JSON's types, for `put` in another process."""
    row, asked = _row_of(method, stack), Options(**options)
    return [row.computed.pack(row.computed.result(bakeable(patch.stack), own)) for patch, own in _parts(row, stack, asked)]


def put(key: str, stack: Stack, method: str, data: list[dict], live: tuple[Place, ...] = ()) -> None:
    """Keep what `packed` gave in another process under the key that `key_of` gives."""
    row = _row_of(method, stack)
    for (patch, _), own_key, own in zip(_parts(row, stack, Options(live)), key.split("\n"), data):
        row.computed.put(own_key, bakeable(patch.stack), own)


def glossy_of_each(count: int) -> int:
    """How many glossy lobes the bakes of `count` patches may have each, so that with one diffuse lobe all are within MAX_CLOSURES.

    At least one, which of eight patches or more share pools (`pools`).
    """
    return max(1, (MAX_CLOSURES - 1) // count)


def _parts(row: Method, stack: Stack, options: Options) -> list[tuple[Patch, Options]]:
    """The patches of a stack, each with its own options: live values are placed by its layers; what is always live needs no place.

    Those of methods that compute first are without anisotropies that rest (`without_idle`).
    """
    for place in options.live:
        if place.layer is not None and not 0 <= place.layer < len(stack.layers):
            raise LaminaError("live value: {place} of a stack of {count} layers, which are numbered from 0", place=place, count=len(stack.layers))
    parts = patches(stack)
    if row.computed is None:
        return [(patch, options) for patch in parts]
    glossy = min(options.glossy or row.computed.most_glossy, glossy_of_each(len(parts)))
    result = []
    for patch in parts:
        live = (place for place in map(patch.place, options.live) if place is not None and place.name not in ALWAYS_LIVE)
        told, moving = without_idle(patch.stack, tuple(live))
        own = Options((*moving, *not_bakeable(told)), options.tolerance, glossy, options.progress)
        result.append((replace(patch, stack=told), own))
    return result


def _with_idle(made: Made, stack: Stack) -> Made:
    """What is made of a stack without its anisotropies of 0, of the whole one."""
    return replace(made, stack=stack, lobe_set=_live_set_of(stack, made.lobe_set))


def _live_set_of(stack: Stack, like: LobeSet) -> LobeSet:
    """The live lobe set of a stack of the method that another is of."""
    return featured_analytic(stack) if isinstance(like, AnalyticLobes) else type(like)(stack)


def require_bake_follows(stack: Stack, live: tuple[Place, ...] = ()) -> None:
    """Raise LaminaError for a stack that scatters, which bakes alone know, and has what no bake follows."""
    if scatters(stack) and (not_bakeable(stack) or not can_follow(bakeable(stack), live)):
        if lost := not_bakeable(stack):
            raise LaminaError("a medium that scatters cannot be had together with {what}; choose one of the two", what=named(stack, lost))
        raise LaminaError("no quality follows {what} where a medium scatters; take its texture or animation away", what=named(stack, live))


def _made(row: Method, stack: Stack, options: Options) -> Made:
    OpticalStack.of(stack, row)  # refuses what the method does not know, before any work
    if row.computed is None:
        return row.make(stack, options)
    plain = bakeable(stack)
    require_bake_follows(stack, options.live)
    if row.follows(plain, options.live):
        made = row.make(plain, options)
    else:
        lobe_set = featured_analytic(plain)
        made = Made(row.name, plain, lobe_set, f"{lobe_set.name}, as a bake cannot {beyond_bakes(plain, options.live)}")
    if not not_bakeable(stack):
        return made
    # what is chosen for the plain stack, which has a truth that is quick to compute, is made of the whole one
    whole = _live_set_of(stack, made.lobe_set)
    reason, choice = made.reason, made.choice
    if whole.name != made.lobe_set.name:
        reason, choice = f"{whole.name}, the one live quality that knows thin films", None
    elif row is auto.METHOD:
        reason += f"; errors are those without {needs_live(stack)}"
    return Made(row.name, stack, whole, reason, choice)
