# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of the tier `analytic` as one array parameter: it stays at its default, takes no time and makes no socket."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from ...reference_py.network.analytic import calibration, tables
from ...reference_py.stack import Stack

# Blocks of a distribution's tables, in their order in the shader.
_BLOCKS = ("thin", "dense", "diffuse", "gain", "closure")


@dataclass(frozen=True)
class Tables:
    """Tables of the distributions `kinds`, each once: a shader carries no others."""

    kinds: tuple[str, ...]

    @classmethod
    def of(cls, stack: Stack) -> "Tables":
        return cls(tuple(sorted({e["distribution"] for e in (*stack.layers, stack.base) if "distribution" in e})))

    @property
    def name(self) -> str:
        """The parameter's: patches of a surface may need tables of different distributions."""
        return "Table" + "".join(kind.title() for kind in self.kinds)

    def start(self, distribution: str) -> int:
        """Where the tables of a distribution start."""
        return self.kinds.index(distribution) * _starts()[-1]

    def arguments(self, distribution: str) -> str:
        """What functions are given for a distribution: `table` and `kind`."""
        return f"{self.name}, {self.start(distribution)}"

    @property
    def arrays(self) -> tuple[str, ...]:
        """The declaration of the parameter, if there is one."""
        return (_declaration(self.name, self.kinds),) if self.kinds else ()


@cache
def _declaration(name: str, kinds: tuple[str, ...]) -> str:
    values = np.concatenate([tables.tables()[kind][block].ravel() for kind in kinds for block in _BLOCKS])
    return f"    float {name}[{values.size}] = {{{','.join(str(v) for v in np.rint(values / tables.UNIT).astype(int))}}},"


@cache
def _starts() -> list[int]:
    """Where each block starts within the tables of a distribution, then where they end."""
    sizes = tables.tables()["ggx"]
    return np.cumsum([0, *(sizes[block].size for block in _BLOCKS)]).tolist()


def constants() -> str:
    """Sizes of the tables and the tier's calibration as preprocessor constants."""
    values: dict[str, float] = {
        "MOST_RHO": tables.MOST_RHO, "RHO_CELLS": tables.RHO_CELLS, "ALPHA_CELLS": tables.ALPHA_CELLS, "UNIT": tables.UNIT,
        "T_KNOTS": len(tables.T), "V_KNOTS": len(tables.V), "CLOSURE_CELLS": tables.CLOSURE_CELLS,
        **{block.upper(): start for block, start in zip(_BLOCKS, _starts())},
    }  # fmt: skip
    for name, value in vars(calibration).items():
        if name.isupper():
            values |= {f"{name}_{i}": v for i, v in enumerate(value)} if isinstance(value, tuple) else {name: value}
    return "".join(f"#define {name} {value if isinstance(value, int) else format(float(value), '#.9g')}\n" for name, value in values.items())
