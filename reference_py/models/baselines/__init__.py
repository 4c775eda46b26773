# SPDX-License-Identifier: GPL-3.0-or-later
"""Baselines: other people's models of a coated material, so that charts compare like with like.

Each takes a stack and sets what a user of that model would; each module's head gives source, mapping and limits.
Those of `BASELINES` are in the registry; LayeredBxdf, which is stochastic and slow, serves charts alone.
"""

from .ashikhmin_shirley import AshikhminShirley
from .belcour import Belcour
from .cycles_layer import CyclesLayer
from .kelemen import Kelemen
from .lafortune import Lafortune
from .layered_bxdf import LayeredBxdf
from .openpbr_coat import OpenPbrCoat
from .principled_coat import PrincipledCoat
from .schlick import Schlick
from .torrance_sparrow import TorranceSparrow

BASELINES = (
    TorranceSparrow,
    CyclesLayer,
    PrincipledCoat,
    Belcour,
    OpenPbrCoat,
    Kelemen,
    AshikhminShirley,
    Schlick,
    Lafortune,
)

__all__ = ["BASELINES", "LayeredBxdf", *(baseline.__name__ for baseline in BASELINES)]
