# SPDX-License-Identifier: GPL-3.0-or-later
"""The package as others receive it: the extension's zip, the Python wheel, licence headers, no traces of one machine."""

import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import lamina
from lamina.reference_py.version import version

ROOT = Path(lamina.__file__).resolve().parent
SHIPPED_FOLDERS = {"addon", "osl", "reference_py"}
SHIPPED_FILES = {"__init__.py", "blender_manifest.toml", "LICENSE", "README.md"}
NOT_SOURCE = {"build", "dist", "manual", "__pycache__"}
# Home and work folders of whoever made a file.
MACHINE_PATH = re.compile(rb"(?<![\w.}])/(?:home|root|work|Users)/\w|/tmp/[v]/")


def run(*command: object, **options: object) -> str:
    result = subprocess.run([str(part) for part in command], capture_output=True, text=True, **options)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def source_files() -> list[Path]:
    """Every file of the project, as paths below `ROOT`: neither built, nor hidden, except the CI script."""
    files = [path.relative_to(ROOT) for path in ROOT.rglob("*") if path.is_file()]
    return [
        path for path in files if not NOT_SOURCE.intersection(path.parts) and not any(part.startswith(".") or part.endswith(".egg-info") for part in path.parts)
    ] + [Path(".ci/run")]


@pytest.fixture(scope="module")
def extension_zip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The extension, built by Blender's own tool."""
    folder = tmp_path_factory.mktemp("dist")
    run(sys.executable, ROOT / "tools" / "extension.py", "build", folder)
    return folder / f"lamina-{version()}.zip"


def zip_names(path: Path) -> set[str]:
    with zipfile.ZipFile(path) as archive:
        return {name for name in archive.namelist() if not name.endswith("/")}


def test_zip_validates_with_tags(extension_zip: Path) -> None:
    run(sys.executable, ROOT / "tools" / "extension.py", "validate", extension_zip)


def test_zip_holds_what_runs_and_nothing_else(extension_zip: Path) -> None:
    expected = {path.as_posix() for path in source_files() if path.parts[0] in SHIPPED_FOLDERS or path.as_posix() in SHIPPED_FILES}
    # the manual is there where `make docs` built it, as `make zip` does
    assert {name for name in zip_names(extension_zip) if not name.startswith("manual/")} == expected
    assert SHIPPED_FILES <= expected


@pytest.mark.blender
def test_zip_registers_alone_under_another_name(extension_zip: Path, tmp_path: Path) -> None:
    """Blender imports an extension as bl_ext.REPOSITORY.lamina, so nothing may rely on the name or on the source tree."""
    with zipfile.ZipFile(extension_zip) as archive:
        archive.extractall(tmp_path / "repository" / "lamina")
    script = (
        "import sys, bpy, repository.lamina as extension\n"
        "extension.register()\n"
        "extension.unregister()\n"
        "absolute = sorted(name for name in sys.modules if name.split('.')[0] == 'lamina')\n"
        "assert not absolute, absolute\n"
        "import os; os._exit(0)\n"  # Blender 4.5's wheel can hang in its exit handlers
    )
    run(sys.executable, "-c", script, cwd=tmp_path)


@pytest.mark.blender
def test_an_installed_extension_writes_to_its_own_folder(extension_zip: Path, tmp_path: Path) -> None:
    repository = tmp_path / "extensions" / "user_default"
    with zipfile.ZipFile(extension_zip) as archive:
        archive.extractall(repository / "lamina")
    script = (
        "import sys, types, bpy\n"
        f"for name, path in (('bl_ext', []), ('bl_ext.user_default', [{str(repository)!r}])):\n"
        "    sys.modules[name] = types.ModuleType(name)\n"
        "    sys.modules[name].__path__ = path\n"
        "from bl_ext.user_default.lamina.addon.blender import user_folders\n"
        "from bl_ext.user_default.lamina.addon.library import user_presets\n"
        "assert user_presets.names() == []\n"
        "print('FOLDERS', user_folders.cache_folder(), user_folders.presets_folder(), flush=True)\n"
        "import os; os._exit(0)\n"
    )
    environment = {k: v for k, v in os.environ.items() if k not in ("LAMINA_CACHE", "LAMINA_PRESETS")}
    said = run(sys.executable, "-c", script, env=environment | {"BLENDER_USER_RESOURCES": str(tmp_path)})
    own = tmp_path / "extensions" / ".user" / "user_default" / "lamina"
    assert f"FOLDERS {own / 'bakes'} {own / 'presets'}" in said


def test_wheel_has_the_zips_version_and_files(extension_zip: Path, tmp_path: Path) -> None:
    pytest.importorskip("setuptools", minversion="77")  # older ones cannot read the licence in pyproject.toml
    source = tmp_path / "source"
    with zipfile.ZipFile(extension_zip) as archive:
        archive.extractall(source)
    for name in ("pyproject.toml", "setup.py"):
        shutil.copy(ROOT / name, source)
    run(sys.executable, "-m", "pip", "wheel", "--no-build-isolation", "--no-deps", "--no-index", "-w", tmp_path, source)
    (wheel,) = tmp_path.glob("*.whl")
    assert wheel.name.startswith(f"lamina-{version()}-")
    without = ("README.md", "LICENSE", "manual/")  # the manual is the extension's alone
    needed = {f"lamina/{name}" for name in zip_names(extension_zip) if not name.startswith(without)}
    assert needed <= zip_names(wheel)


def test_import_leaves_bpy_alone() -> None:
    """reference_py and the command line must start without Blender, and quickly."""
    script = (
        "import importlib, pkgutil, sys\n"
        "import lamina, lamina.addon.cli.main, lamina.reference_py as package\n"
        "for module in pkgutil.walk_packages(package.__path__, package.__name__ + '.'):\n"
        "    importlib.import_module(module.name)\n"
        "assert 'bpy' not in sys.modules\n"
    )
    run(sys.executable, "-c", script)


def test_every_source_file_states_its_licence() -> None:
    def states_it(path: Path) -> bool:
        head = (ROOT / path).read_text(encoding="utf-8").splitlines()[:3]
        return any("SPDX-License-Identifier: GPL-3.0-or-later" in line for line in head)

    sources = [path for path in source_files() if path.suffix in {".py", ".osl", ".h", ".sh"}] + [Path(".ci/run")]
    assert [path.as_posix() for path in sources if not states_it(path)] == []


def test_no_file_names_a_folder_of_one_machine() -> None:
    def content(path: Path) -> bytes:
        data = (ROOT / path).read_bytes()
        if path.suffix == ".blend" and data.startswith(b"\x28\xb5\x2f\xfd"):  # a compressed .blend is zstd frames
            import zstandard

            return zstandard.ZstdDecompressor().stream_reader(data, read_across_frames=True).read()
        return data

    found = {path.as_posix(): match.group() for path in source_files() if (match := MACHINE_PATH.search(content(path)))}
    assert found == {}
