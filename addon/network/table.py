# SPDX-License-Identifier: GPL-3.0-or-later
"""The shader of a network in tables: constants over the view, and no parameters that make sockets.

Tables are array parameters: they stay at their defaults, take no time per shading, and make no sockets.
"""

import numpy as np

from ...reference_py.network.lobe import DielectricCurve
from ...reference_py.network.table import KNOTS, MIN_COS_O, DiffuseTable, GlossyTable, TableNetwork
from .parts import fill, listed, narrow, numbers, right_nested


def table_text(network: TableNetwork, title: str) -> str:
    """The text of the shader, its name still @SHADER@."""
    lobes = [_lobe(i, table) for i, table in enumerate(network.tables)]
    glossy = any(isinstance(t, GlossyTable) for t in network.tables)
    return fill(
        "table.osl",
        TITLE=title,
        FUNCTIONS=narrow() if glossy else "",
        PARAMETERS="\n".join(p for parameters, _ in lobes for p in parameters),
        CELLS=KNOTS - 1,
        LAST=KNOTS - 2,
        MIN_COS_O=f"{MIN_COS_O:g}",
        FRAME=fill("tangent.osl") + fill("plane_of_incidence.osl") if glossy else "",
        LOBES="".join(body for _, body in lobes),
        SUM=right_nested([f"lobe_{i}" for i in range(len(lobes))]),
    )


def _lobe(index: int, table: GlossyTable | DiffuseTable) -> tuple[list[str], str]:
    """Array parameters of a lobe and the statements that make its closure."""
    parameters: list[str] = []
    weight = _value(parameters, f"Weight{index}", table.weight)
    if isinstance(table, DiffuseTable):
        return parameters, fill("table_diffuse.osl", INDEX=index, WEIGHT=weight)
    alpha_x, alpha_y, slope = (_value(parameters, f"{name}{index}", column) for name, column in zip(("AlphaX", "AlphaY", "Tilt"), table.shape.T))
    values = dict(INDEX=index, WEIGHT=weight, DISTRIBUTION=table.distribution, ALPHA_X=alpha_x)
    if isinstance(table.fresnel, DielectricCurve):
        return parameters, fill("table_dielectric.osl", ETA=f"{table.fresnel.eta:.9g}", **values)
    if not np.any(table.shape[:, 2]) and np.all(table.shape[:, 0] == table.shape[:, 1]):
        return parameters, fill("table_isotropic.osl", **values)
    return parameters, fill("table_anisotropic.osl", ALPHA_Y=alpha_y, TILT=slope, **values)


def _value(parameters: list[str], name: str, column: np.ndarray) -> str:
    """An expression for a column (KNOTS,) or (KNOTS, 3) at the view; a table becomes an array parameter."""
    color = column.ndim == 2
    if np.all(column == column[0]):
        return f"color({numbers(column[0])})" if color else f"{column[0]:.9g}"
    kind = "color" if color else "float"
    entries = listed(f"color({numbers(row)})" if color else f"{row:.9g}" for row in column)
    parameters.append(f"    {kind} {name}[{KNOTS}] = {{{entries}}},")
    return f"mix({name}[cell], {name}[cell + 1], between)"
