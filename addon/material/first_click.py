# SPDX-License-Identifier: GPL-3.0-or-later
"""What the first click of a session would do once, done before it in pieces. Changes no data of Blender's."""

from collections.abc import Iterator
from importlib import import_module

from ...reference_py.lobes.cache import prepare
from ...reference_py.lobes.methods import provisional
from ...reference_py.material.schema import CONDUCTOR, DIELECTRIC, LAMBERT
from ...reference_py.material.stack import Stack
from ..blender import environment
from ..shader.nodes.stock_nodes import eevee_stock_tables, stock_tables
from ..shader.osl.generate import generate


def pieces() -> Iterator[None]:
    """Each step takes some hundredths of a second: the compiler's modules, the digest that bakes are found by, and the tables that shaders share."""
    if environment.osl_available()[0]:
        import_module("cycles.osl")
        import_module("oslquery")
        yield
    prepare()
    yield
    for base in (LAMBERT, CONDUCTOR):
        made = provisional(Stack.from_dict({"layers": [{"kind": DIELECTRIC.name}], "base": {"kind": base.name}}))
        yield
        generate(made)
        yield
        eevee_stock_tables(made, stock_tables(made))
        yield
