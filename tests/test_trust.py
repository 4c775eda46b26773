# SPDX-License-Identifier: GPL-3.0-or-later
"""What runs is what ships: no code from data, no network, and no more permissions than files."""

import ast
import tomllib
from pathlib import Path

import pytest

import lamina

ROOT = Path(lamina.__file__).resolve().parent
SOURCES = sorted(file for folder in ("addon", "reference_py") for file in (ROOT / folder).rglob("*.py")) + [ROOT / "__init__.py"]
FORBIDDEN_MODULES = {"pickle", "cPickle", "shelve", "marshal", "dill", "code", "codeop", "socket", "ssl", "http", "urllib", "ftplib", "smtplib", "requests",
                     "xmlrpc", "asyncio", "webbrowser", "ctypes", "runpy"}  # fmt: skip
FORBIDDEN_CALLS = {"eval", "exec", "compile", "__import__"}
FORBIDDEN_ATTRIBUTES = {"system", "popen", "online_access"}


def offences(source: str) -> list[str]:
    """What a text imports or calls that data could abuse. Methods may be called eval; the built-in may not."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found += [a.name for a in node.names if a.name.split(".")[0] in FORBIDDEN_MODULES]
        elif isinstance(node, ast.ImportFrom) and not node.level and node.module.split(".")[0] in FORBIDDEN_MODULES:
            found.append(node.module)
        elif isinstance(node, ast.Call):
            if isinstance(node.func, ast.Name) and node.func.id in FORBIDDEN_CALLS:
                found.append(node.func.id)
            if isinstance(node.func, ast.Attribute) and node.func.attr in FORBIDDEN_ATTRIBUTES:
                found.append(node.func.attr)
            found += ["shell=True" for k in node.keywords if k.arg == "shell" and getattr(k.value, "value", None)]
            found += ["allow_pickle" for k in node.keywords if k.arg == "allow_pickle" and getattr(k.value, "value", None)]
    return found


@pytest.mark.parametrize("source", ["eval('1')", "import pickle", "from urllib.request import urlopen", "os.system('x')", "subprocess.run('x', shell=True)",
                                    "np.load(f, allow_pickle=True)", "import http.client"])  # fmt: skip
def test_offences_are_seen(source):
    assert offences(source)


def test_no_code_from_data_and_no_network():
    found = {file.relative_to(ROOT).as_posix(): what for file in SOURCES if (what := offences(file.read_text(encoding="utf-8")))}
    assert len(SOURCES) > 100 and found == {}


def test_the_manifest_asks_for_files_and_nothing_else():
    assert list(tomllib.loads((ROOT / "blender_manifest.toml").read_text())["permissions"]) == ["files"]


def test_every_pinned_package_has_its_hashes():
    for file in (ROOT / "requirements").glob("*.txt"):
        lines = [line for line in file.read_text().splitlines() if line and not line.startswith("#")]
        for line, following in zip(lines, [*lines[1:], ""]):
            if not line.startswith(" "):
                assert "==" in line and following.strip().startswith("--hash=sha256:"), f"{file.name}: {line}"
