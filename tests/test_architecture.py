# SPDX-License-Identifier: GPL-3.0-or-later
"""The arrows between folders are those that docs/architecture.md draws, all of them, and they go one way.

An arrow is an import, at the top of a file or inside a function. Nodes are folders; a file that stands at the top of
`reference_py` or `addon` is a node of its own. Run as a script it prints the list for the document.
"""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DOCUMENT = ROOT / "docs" / "architecture.md"
TOPS = ("addon", "reference_py", "study", "demo_blend")
LAYERED = ("addon", "reference_py")


def modules(root: Path) -> dict[str, Path]:
    """Dotted names of all modules of the tree, and their files."""
    files = [path for top in TOPS for path in sorted((root / top).rglob("*.py"))]
    return {".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__"): path for path in files}


def node_of(path: Path, root: Path) -> str:
    """The node that a file belongs to."""
    parts = path.relative_to(root).with_suffix("").parts
    if parts[0] not in LAYERED:
        return parts[0]
    return "/".join(parts) if len(parts) == 2 and parts[1] != "__init__" else "/".join(parts[:-1])


def imported(path: Path, name: str, known: dict[str, Path]):
    """The modules that a module imports, wherever in its text."""
    package = name.split(".") if path.name == "__init__.py" else name.split(".")[:-1]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.ImportFrom) or not node.level:
            continue
        base = package[: len(package) - node.level + 1] + (node.module or "").split(".") * bool(node.module)
        for alias in node.names:
            for target in (".".join([*base, alias.name]), ".".join(base)):
                if target in known:
                    yield target
                    break


def arrows(root: Path) -> dict[str, set[str]]:
    """Node by node, the nodes that it uses."""
    known = modules(root)
    result: dict[str, set[str]] = {}
    for name, path in known.items():
        here = node_of(path, root)
        result.setdefault(here, set()).update(there for target in imported(path, name, known) if (there := node_of(known[target], root)) != here)
    return result


def circle(graph: dict[str, set[str]]) -> list[str]:
    """A circle of a graph, its first node again at the end; empty if there is none."""
    done: set[str] = set()

    def visit(node: str, way: list[str]) -> list[str]:
        if node in way:
            return [*way[way.index(node) :], node]
        if node in done:
            return []
        for other in sorted(graph.get(node, ())):
            if found := visit(other, [*way, node]):
                return found
        done.add(node)
        return []

    return next((found for node in sorted(graph) if (found := visit(node, []))), [])


def documented() -> dict[str, set[str]]:
    """The arrows that the document lists."""
    block = re.search(r"```arrows\n(.*?)```", DOCUMENT.read_text(encoding="utf-8"), re.S)
    assert block, f"{DOCUMENT.name} has no list of arrows"
    rows = (line.partition(" -> ") for line in block[1].splitlines() if " -> " in line)
    return {here: set(there.split(", ")) for here, _, there in rows}


def test_arrows_are_those_of_the_document():
    found = {here: there for here, there in arrows(ROOT).items() if there}
    drawn = documented()
    assert {(a, b) for a, there in found.items() for b in there} == {(a, b) for a, there in drawn.items() for b in there}


def test_arrows_go_one_way():
    assert circle(arrows(ROOT)) == []


def test_nothing_uses_the_study_or_the_demo_and_the_reference_uses_no_blender():
    graph = arrows(ROOT)
    for here, there in graph.items():
        if here not in ("study", "demo_blend"):
            assert not there & {"study", "demo_blend"}, here
        if here.startswith("reference_py"):
            assert all(other.startswith("reference_py") for other in there), here


# TAKE is import, so that a search for imports in texts of tests finds none of these.
@pytest.mark.parametrize("text", ["from ..cli TAKE main\n", "def late():\n    from ..cli.main TAKE run\n"], ids=["at the top", "inside a function"])
def test_a_circle_is_found(tmp_path, text):
    """A deliberate one: what a command uses imports the commands."""
    for top in TOPS:
        (tmp_path / top).mkdir()
    for folder, words in (("cli", "from ..batch TAKE job\n"), ("batch", text)):
        (tmp_path / "addon" / folder).mkdir()
        (tmp_path / "addon" / folder / "__init__.py").write_text("")
        (tmp_path / "addon" / folder / ("main.py" if folder == "cli" else "job.py")).write_text(words.replace("TAKE", "import"))
    assert circle(arrows(tmp_path)) in (["addon/batch", "addon/cli", "addon/batch"], ["addon/cli", "addon/batch", "addon/cli"])


if __name__ == "__main__":
    for here, there in sorted(arrows(ROOT).items()):
        if there:
            print(f"{here} -> {', '.join(sorted(there))}")
