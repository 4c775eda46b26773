# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of two lobes that are alike in kind is which: at every view that at which a grid's tables change least from view to view.

Fits find lobes in any order. Between two views where they have changed places a table would interpolate a narrow lobe to a wide one, and
what it shows there is neither's: of bare metals up to 19 % too much light.
"""

from collections import defaultdict
from dataclasses import replace
from itertools import permutations

import numpy as np

from ..view_table import KNOTS, GlossyTable, TableLobes

# Alpha of what counts as a mirror.
_MIRROR = 1e-4


def in_one_order(nodes: dict[tuple[int, ...], TableLobes]) -> dict[tuple[int, ...], TableLobes]:
    """The nodes with their lobes in such an order, the same at all nodes, as each lobe began where its neighbour node's had ended."""
    kinds = defaultdict(list)
    for i, table in enumerate(next(iter(nodes.values())).tables):
        if isinstance(table, GlossyTable) and table.fresnel is None and not table.is_mirror:
            kinds[table.distribution].append(i)
    for alike in kinds.values():
        if len(alike) > 1:
            nodes = _reordered(nodes, alike)
    return nodes


def _reordered(nodes: dict[tuple[int, ...], TableLobes], alike: list[int]) -> dict[tuple[int, ...], TableLobes]:
    """The nodes with the lobes of these numbers in one order."""
    shape, weight = (np.array([[getattr(lobes.tables[i], name) for i in alike] for lobes in nodes.values()]) for name in ("shape", "weight"))
    order = _order(shape, np.mean(weight, axis=-1))
    views = np.arange(KNOTS)
    result = {}
    for node, own_shape, own_weight in zip(nodes, shape, weight):
        tables = list(nodes[node].tables)
        for i, place in zip(alike, order):
            tables[i] = replace(tables[i], shape=own_shape[place, views], weight=own_weight[place, views])
        result[node] = replace(nodes[node], tables=tuple(tables))
    return result


def _order(shape: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """(lobes, KNOTS) the number of the lobe in each place; of shapes (nodes, lobes, KNOTS, 3) and weights (nodes, lobes, KNOTS).

    The way over the views of least sum of what light a change of widths concerns.
    """
    widths = np.log(np.maximum(shape[..., :2], _MIRROR))
    orders = np.array(list(permutations(range(shape.shape[1]))))
    cost, came_from = np.zeros(len(orders)), []
    for view in range(KNOTS - 1):
        apart = np.sum(np.abs(widths[:, orders[:, None], view] - widths[:, orders[None], view + 1]), axis=-1)
        light = weight[:, orders[:, None], view] + weight[:, orders[None], view + 1]
        through = cost[:, None] + np.sum(apart * light, axis=(0, 3))
        came_from.append(np.argmin(through, axis=0))
        cost = np.min(through, axis=0)
    path = [int(np.argmin(cost))]
    for previous in reversed(came_from):
        path.append(int(previous[path[-1]]))
    return orders[path[::-1]].T
