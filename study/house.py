# SPDX-License-Identifier: GPL-3.0-or-later
"""How the house stands beside what it was before it was rebuilt: `make house`, or `python -m lamina.study.house [COMMIT]`

Counts the same things by the same rules in this checkout and in the commit's, prints both import graphs, and writes figures/house.csv.
Needs the extension in dist/ (`make zip`).
"""

import ast
import contextlib
import json
import re
import runpy
import subprocess
import sys
import tempfile
import zipfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from .compare_commits import START
from .tables import FIGURES, ROOT, write_table

# The parent of the first commit of the rebuilding.
BEFORE = "b078625"
CODE = ("addon", "reference_py", "osl")
KINDS = {"dielectric", "lambert", "oren_nayar", "conductor", "ggx", "beckmann"}
METHODS = {"weidlich_wilkie", "analytic", "baked", "auto"}
# Names that ask how a lobe set was made: what decides on a class of lobe sets, and what is told of a method or a stack, before and now.
LOBE_SET = re.compile(r"^(Table|Grid|Live|Analytic|Paper|WeidlichWilkie|Auto)(Network|Lobes|Tables)$")
TOLD = {"HOLD_VALUES", "holds_values", "unbaked", "not_bakeable", "needs_live"}
# What a newcomer looks for, and the words he tries on the list of files.
QUESTIONS = {
    "Where is Fresnel?": "fresnel",
    "Where is a texture made to follow?": "live",
    "Where would I add a base kind?": "bases|schema",
    "What writes OSL?": "osl/(generate|emit)",
    "Where are bakes kept?": "cache",
}
# The way from what a method made to its text, by the names of both trees: files that are entered, and calls back into one that has not ended.
TRACE = (
    START
    + """generate = one_of("addon.shader.osl.generate:generate", "addon.network.osl:generate")
make = one_of("reference_py.lobes.methods:make_lobe_set", "reference_py.network:make_network")
load = one_of("reference_py.material.presets:load", "reference_py.presets:load")
rooms, returns, way = set(), set(), []

def watch(frame, event, _):
    if event == "call":
        room = frame.f_code.co_filename.removeprefix(root + "/")
        inside = room.startswith("addon/") and frame.f_code.co_name != "<module>"
        if inside:
            rooms.add(room)
            if way and way[-1] != room and room in way:
                returns.add((next(w for w in reversed(way) if w), room, frame.f_code.co_name))
        way.append(room if inside else way[-1] if way else "")
    elif event == "return" and way:
        way.pop()

for name in ("frosted_paint", "patina_copper", "anodised_titanium"):
    for method in ("weidlich_wilkie", "analytic", "baked"):
        made = make(load(name), method)
        sys.setprofile(watch)
        generate(made)
        sys.setprofile(None)
        way.clear()
print(json.dumps([sorted(rooms), sorted(returns)]))
"""
)


@contextlib.contextmanager
def checkout(commit: str) -> Iterator[Path]:
    """A folder with the files of a commit, for a while. Exits with a line where there is no such commit."""
    with tempfile.TemporaryDirectory() as folder:
        archive = subprocess.run(["git", "-C", str(ROOT), "archive", "--end-of-options", commit], capture_output=True)
        if archive.returncode:
            sys.exit(f"lamina: no commit {commit!r} in this repository; give one that `git log` lists")
        subprocess.run(["tar", "-x", "-C", folder], input=archive.stdout, check=True)
        yield Path(folder)


def python_files(root: Path, *tops: str) -> list[Path]:
    return [path for top in tops for path in sorted((root / top).rglob("*.py")) if "__pycache__" not in path.parts]


def trees(root: Path, *tops: str) -> Iterator[tuple[Path, ast.Module]]:
    for path in python_files(root, *tops):
        yield path, ast.parse(path.read_text(encoding="utf-8"))


def in_circles(graph: dict[str, set[str]]) -> set[str]:
    """The nodes from which a way leads back to them."""

    def reached(start: str) -> set[str]:
        seen, left = set(), [start]
        while left:
            new = graph.get(left.pop(), set()) - seen
            seen |= new
            left += new
        return seen

    return {node for node in graph if node in reached(node)}


def graph_of(root: Path) -> dict[str, set[str]]:
    return runpy.run_path(str(ROOT / "tests" / "test_architecture.py"))["arrows"](root)


def names(node: ast.AST) -> set[str]:
    """Names and attributes of an expression."""
    return {each.id if isinstance(each, ast.Name) else each.attr for each in ast.walk(node) if isinstance(each, ast.Name | ast.Attribute)}


def texts(node: ast.Compare) -> set[object]:
    """The literals of a comparison."""
    return {each.value for each in ast.walk(node) if isinstance(each, ast.Constant)}


def asks_how_it_was_made(tree: ast.Module) -> bool:
    """Whether a file decides on baked, live or stand-in."""
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=name, ctx=ast.Load()) | ast.Attribute(attr=name, ctx=ast.Load()) if name in TOLD:
                return True
            case ast.Call(func=ast.Name(id="isinstance")) | ast.Compare() if any(map(LOBE_SET.match, names(node))):
                return True
            case ast.Compare() if METHODS & texts(node):
                return True
    return False


def asks_for_kinds(root: Path) -> Counter:
    """Comparisons with the name of a kind or a distribution, by file."""
    found: Counter = Counter()
    for path, tree in trees(root, "addon", "reference_py"):
        for node in ast.walk(tree):
            found[path] += isinstance(node, ast.Compare) and bool(KINDS & texts(node))
    return +found


def naming(root: Path, kind: str) -> set[Path]:
    """Files of the code in which the name of a kind stands."""
    files = [path for top in CODE for path in (root / top).rglob("*") if path.suffix in (".py", ".osl", ".h")]
    return {path for path in files if re.search(rf"\b{kind}\b", path.read_text(encoding="utf-8"))}


def shared_names(root: Path) -> dict[str, list[str]]:
    """Names of files that stand in several folders."""
    places: dict[str, list[str]] = {}
    for path in python_files(root, "addon", "reference_py", "study", "demo_blend"):
        if not path.name.startswith("__"):
            places.setdefault(path.name, []).append(path.parent.relative_to(root).as_posix())
    return {name: folders for name, folders in places.items() if len(folders) > 1}


def without_docstring(root: Path) -> list[str]:
    """Public functions, classes and methods of the reference that say nothing of themselves."""
    found = []
    for path, tree in trees(root, "reference_py"):
        classes = [node for node in tree.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_")]
        for node in (*tree.body, *(node for each in classes for node in each.body)):
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_") and not ast.get_docstring(node):
                found.append(f"{path.relative_to(root)}:{node.lineno} {node.name}")
    return found


def compares_arrays(root: Path) -> list[str]:
    """Frozen dataclasses that hold arrays and do not say `eq=False`: comparing two would fail, and the methods for it cost each start time."""
    found = []
    for path, tree in trees(root, "reference_py", "addon"):
        for node in (each for each in ast.walk(tree) if isinstance(each, ast.ClassDef)):
            is_frozen = any(ast.unparse(decorator) == "dataclass(frozen=True)" for decorator in node.decorator_list)
            if is_frozen and any(isinstance(field, ast.AnnAssign) and "ndarray" in ast.unparse(field.annotation) for field in node.body):
                found.append(f"{path.relative_to(root)}:{node.lineno} {node.name}")
    return found


def lines_with(root: Path, pattern: str, *tops: str) -> int:
    return sum(len(re.findall(pattern, path.read_text(encoding="utf-8"))) for path in python_files(root, *tops))


def built(root: Path, folder: Path) -> Path:
    """The extension of a checkout, built by its own tool; this one's is what `make zip` left."""
    if root != ROOT:
        subprocess.run([sys.executable, str(root / "tools" / "extension.py"), "build", str(folder)], check=True, capture_output=True)
    return next((root / "dist" if root == ROOT else folder).glob("lamina-*.zip"))


def contents(path: Path) -> list[tuple[str, int, int]]:
    """Folder, files and packed bytes of an extension, the largest first."""
    files, sizes = Counter(), Counter()
    with zipfile.ZipFile(path) as archive:
        for each in archive.infolist():
            folder = "/".join(each.filename.split("/")[:-1][:2]) or "."
            files[folder] += not each.is_dir()
            sizes[folder] += each.compress_size
    return [(folder, files[folder], size) for folder, size in sizes.most_common()]


def kilobytes(path: Path, pattern: str) -> int:
    """Packed size of an extension's files whose path has the words."""
    with zipfile.ZipFile(path) as archive:
        return round(sum(each.compress_size for each in archive.infolist() if re.search(pattern, each.filename)) / 1000.0)


def answers(root: Path, pattern: str) -> list[str]:
    """Files of the code whose path has the words."""
    return [
        path
        for top in CODE
        for path in sorted(p.relative_to(root).as_posix() for p in (root / top).rglob("*") if p.is_file())
        if re.search(pattern, path) and "__pycache__" not in path
    ]


def way_to_text(root: Path) -> tuple[list[str], list[list[str]]]:
    """The files of the add-on between what a method made and its text, and the calls that lead back into one."""
    done = subprocess.run([sys.executable, "-c", TRACE, str(root)], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{root}: {done.stderr.strip().splitlines()[-1]}")
    return tuple(json.loads(done.stdout.splitlines()[-1]))


def measured(root: Path, folder: Path) -> dict[str, object]:
    """All counts of a checkout, by words."""
    graph = graph_of(root)
    rooms, returns = way_to_text(root)
    extension = built(root, folder)
    kinds = asks_for_kinds(root)
    return {
        "folders and top files in the import graph": len(graph),
        "arrows between them": sum(map(len, graph.values())),
        "of them in a circle": len(in_circles(graph)),
        "files from a lobe set to its OSL text": len(rooms),
        "calls back into one of them": len(returns),
        "files that ask baked, live or stand-in": sum(asks_how_it_was_made(tree) for _, tree in trees(root, "addon", "reference_py")),
        "comparisons with a kind's name": kinds.total(),
        "files with such comparisons": len(kinds),
        **{f"files that name {kind}": len(naming(root, kind)) for kind in ("oren_nayar", "beckmann", "dielectric")},
        "names of files that stand in several folders": len(shared_names(root)),
        "lines that silence a check": lines_with(root, "# no" + "qa", "addon", "reference_py", "study", "demo_blend", "tests", "tools"),
        "public names of the reference without a docstring": len(without_docstring(root)),
        "copies of the least cosine of a view": lines_with(root, r"(?m)^MIN_COS_O =", *CODE),
        "copies of the plane's golden ratio": lines_with(root, r"(?m)^_GOLDEN_2 =", *CODE),
        "files in the extension": sum(count for _, count, _ in contents(extension)),
        "kB of the extension": kilobytes(extension, ""),
        "kB of it that are code": kilobytes(extension, r"\.py$"),
        "kB of it that are code for charts": kilobytes(extension, r"(chart|pareto|viewport|figures|stress|suite|agreement|study).*\.py$"),
        "kB of it that are the manual": kilobytes(extension, "^manual/"),
    }


def main() -> int:
    commit = sys.argv[1] if len(sys.argv) > 1 else BEFORE
    with checkout(commit) as old, tempfile.TemporaryDirectory() as folder:
        for title, root in (("before", old), ("now", ROOT)):
            print(f"\nImport graph {title}")
            for here, there in sorted(graph_of(root).items()):
                print(f"  {here} -> {', '.join(sorted(there))}" if there else f"  {here}")
        was, now = measured(old, Path(folder)), measured(ROOT, Path(folder))
        print("\nNames of files in several folders")
        for name, folders in shared_names(ROOT).items():
            print(f"  {name}: {', '.join(folders)}")
        print("\nQuestions, by the names of files alone")
        for question, pattern in QUESTIONS.items():
            print(f"  {question}\n    before: {', '.join(answers(old, pattern)) or 'nothing'}\n    now: {', '.join(answers(ROOT, pattern)) or 'nothing'}")
        print("\nThe extension: folder, files, kB")
        for name, count, size in contents(built(ROOT, Path(folder))):
            print(f"  {name:32} {count:4} {size / 1000.0:8.0f}")
    heading = ["make house", f"before is {commit}; the same rules in both"]
    print()
    print(write_table(FIGURES / "house.csv", heading, ["what", "before", "now"], [(what, was[what], now[what]) for what in now], report=print))
    return 0


if __name__ == "__main__":
    sys.exit(main())
