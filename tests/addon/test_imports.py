# SPDX-License-Identifier: GPL-3.0-or-later
"""Every import in the tree leads somewhere, those inside functions and in code that other processes get as text too."""

import argparse
import ast
import importlib
import importlib.util
from pathlib import Path

import pytest

pytest.importorskip("bpy")

import lamina
from lamina.addon.cli import main

pytestmark = pytest.mark.blender

ROOT = Path(lamina.__file__).parent
# Extras, what some Blenders or systems lack, and a package that a test makes; everything else must be there.
OPTIONAL = {"matplotlib", "scipy", "OpenImageIO", "resource", "fcntl", "msvcrt", "repository", "mitsuba", "deadline", "mkdocs"}
FILES = sorted(
    path for path in ROOT.rglob("*.py")
    if not any(part.startswith(".") or part in ("build", "dist", "node_modules") for part in path.relative_to(ROOT).parts)
)  # fmt: skip


def imports_of(text: str, package: str):
    """(line, module, name or "") of every import in a source text, and in text constants that are Python themselves."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name, "") for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            module = importlib.util.resolve_name("." * node.level + (node.module or ""), package) if node.level else node.module
            yield from ((node.lineno, module, alias.name) for alias in node.names)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and "import " in node.value:
            try:
                inner = list(imports_of(node.value, package))
            except (SyntaxError, ImportError):
                continue  # words, not code
            yield from ((node.lineno, module, name) for _, module, name in inner)


def problem(module: str, name: str) -> str:
    """Why an import does not work; empty if it does, or if its package is optional and not here."""
    if module.partition(".")[0] in OPTIONAL:
        return ""
    try:
        found = importlib.import_module(module)
    except ImportError as error:
        return f"no module {module}: {error}"
    if name in ("", "*") or hasattr(found, name):
        return ""
    try:
        importlib.import_module(f"{module}.{name}")
    except ImportError:
        return f"{module} has no {name}"
    return ""


def package_of(path: Path) -> str:
    return ".".join(("lamina", *path.relative_to(ROOT).parts[:-1]))


@pytest.mark.parametrize("folder", sorted({path.relative_to(ROOT).parts[0] for path in FILES}))
def test_every_import_resolves(registered_lamina, folder):
    wrong = [
        f"{path.relative_to(ROOT)}:{line}: {told}"
        for path in FILES if path.relative_to(ROOT).parts[0] == folder
        for line, module, name in imports_of(path.read_text(encoding="utf-8"), package_of(path))
        if (told := problem(module, name))
    ]  # fmt: skip
    assert wrong == []


def test_the_search_sees_imports_inside_functions_and_in_code_as_text():
    text = "def f():\n    from ..cache TAKE cache_folder\nCODE = 'TAKE os; from lamina.addon TAKE nothing'\nWORDS = 'they TAKE things'\n"
    text = text.replace("TAKE", "import")  # so that this file has none of them
    found = list(imports_of(text, "lamina.addon.cli"))
    assert found == [(2, "lamina.addon.cache", "cache_folder"), (3, "os", ""), (3, "lamina.addon", "nothing")]
    assert [bool(problem(module, name)) for _, module, name in found] == [True, False, True]


def test_every_command_has_its_function():
    commands = next(a for a in main.build_parser()._actions if isinstance(a, argparse._SubParsersAction)).choices
    for name, command in commands.items():
        module = importlib.import_module(command.get_default("module"))
        assert callable(getattr(module, name)), name
