# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of the tier `analytic` as one array parameter: it stays at its default, takes no time and makes no socket."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from ....reference_py.lobes.analytic import calibration, tables
from ....reference_py.material.schema import ANISOTROPY
from ....reference_py.material.stack import Stack

# Blocks of a distribution's tables, in their order in the shader, and the last of them, for stacks with anisotropy alone.
_BLOCKS = ("thin", "dense", "diffuse", "gain", "closure", "brushed")


@dataclass(frozen=True)
class Tables:
    """Tables of the distributions `kinds`, each once: a shader carries no others."""

    kinds: tuple[str, ...]
    brushed: bool

    @classmethod
    def of(cls, stack: Stack) -> "Tables":
        elements = (*stack.layers, stack.base)
        return cls(tuple(sorted({e["distribution"] for e in elements if "distribution" in e})), any(e.has(ANISOTROPY) for e in elements))

    @property
    def name(self) -> str:
        """The parameter's: patches of a surface may need tables of different distributions."""
        return "Table" + "".join(kind.title() for kind in self.kinds) + ("Brushed" if self.brushed else "")

    def start(self, distribution: str) -> int:
        """Where the tables of a distribution start."""
        return self.kinds.index(distribution) * _starts()[-1 if self.brushed else -2]

    def arguments(self, distribution: str) -> str:
        """What functions are given for a distribution: `table` and `kind`."""
        return f"{self.name}, {self.start(distribution)}"

    @property
    def arrays(self) -> tuple[str, ...]:
        """The declaration of the parameter, if there is one."""
        return (_declaration(self.name, self.kinds, _BLOCKS if self.brushed else _BLOCKS[:-1]),) if self.kinds else ()


@cache
def _declaration(name: str, kinds: tuple[str, ...], blocks: tuple[str, ...]) -> str:
    values = np.concatenate([tables.tables()[kind][block].ravel() for kind in kinds for block in blocks])
    return f"    float {name}[{values.size}] = {{{','.join(str(v) for v in np.rint(values / tables.UNIT).astype(int))}}},"


@cache
def _starts() -> list[int]:
    """Where each block starts within the tables of a distribution, then where they end."""
    sizes = tables.tables()["ggx"]
    return np.cumsum([0, *(sizes[block].size for block in _BLOCKS)]).tolist()


def constants(brushed: bool) -> str:
    """Sizes of the tables, of anisotropic surfaces where there are any, and the tier's calibration as preprocessor constants."""
    values: dict[str, float] = {
        "MOST_RHO": tables.MOST_RHO, "RHO_CELLS": tables.RHO_CELLS, "ALPHA_CELLS": tables.ALPHA_CELLS, "UNIT": tables.UNIT,
        "T_KNOTS": len(tables.T), "V_KNOTS": len(tables.V), "CLOSURE_CELLS": tables.CLOSURE_CELLS,
        **{block.upper(): start for block, start in zip(_BLOCKS[:-1], _starts())},
    }  # fmt: skip
    if brushed:
        values |= {"BRUSHED": _starts()[-2], "LEAST_RATIO": tables.LEAST_RATIO, "LEAST_KAPPA": tables.LEAST_KAPPA}
        values |= {"BRUSHED_ALPHAS": tables.BRUSHED_ALPHAS, "BRUSHED_RATIOS": tables.BRUSHED_RATIOS, "BRUSHED_COSINES": tables.BRUSHED_COSINES}
        values |= {f"BRUSHED_KNOTS_{i}": knot for i, knot in enumerate(np.cos(2.0 * tables.BRUSHED_AZIMUTHS))}
    for name, value in vars(calibration).items():
        if name.isupper():
            values |= {f"{name}_{i}": v for i, v in enumerate(value)} if isinstance(value, tuple) else {name: value}
    return "".join(f"#define {name} {value if isinstance(value, int) else format(float(value), '#.9g')}\n" for name, value in values.items())
