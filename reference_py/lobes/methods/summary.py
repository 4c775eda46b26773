# SPDX-License-Identifier: GPL-3.0-or-later
"""What is said of a lobe set that was made: what it holds, by which methods, at which error and cost."""

from ..made import Made
from ..patch_lobes import PatchLobes
from .cost import cost


def parts_of(made: Made) -> list[Made]:
    """What was made of each patch; the whole itself where there is one."""
    return [part for _, part in made.lobe_set.parts] if isinstance(made.lobe_set, PatchLobes) else [made]


def has_tables(made: Made) -> bool:
    """Whether the shader holds a stack's values."""
    return any(not part.lobe_set.is_live for part in parts_of(made))


def live_methods(made: Made) -> set[str]:
    """The methods of its lobes that are no tables."""
    return {part.lobe_set.name for part in parts_of(made) if part.lobe_set.is_live}


def estimated_error(made: Made, osl: bool) -> float | None:
    """The worst estimated visible error of what the method auto chose, with OSL or in stock nodes, as a share of the light; None where nothing was estimated."""
    parts = parts_of(made)
    if any(part.choice is None for part in parts):
        return None
    return max(part.choice.shown(osl).visible for part in parts)


def estimated_cost(made: Made, osl: bool) -> float:
    """What it costs with OSL or in stock nodes, in units of a plain glossy node's, see `cost.cost`; that of the dearest of its patches."""
    return max(part.choice.shown(osl).cost if part.choice else cost(part.lobe_set) for part in parts_of(made))
