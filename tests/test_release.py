# SPDX-License-Identifier: GPL-3.0-or-later
"""What `make release` puts together is what the manifest says, and every lack is a line."""

import importlib.util
import shutil
import struct
import tomllib
import zipfile
from pathlib import Path

import pytest

import lamina
from lamina.reference_py.version import version

ROOT = Path(lamina.__file__).resolve().parent
_spec = importlib.util.spec_from_file_location("lamina_release", ROOT / "tools" / "release.py")
release = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(release)


@pytest.fixture
def tree(tmp_path):
    """What a release is made of, to change."""
    for name in ("blender_manifest.toml", release.CHANGELOG, release.DESCRIPTION, release.ICON, release.FEATURED):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    return tmp_path


@pytest.fixture
def archive(tmp_path):
    path = tmp_path / f"lamina-{version()}.zip"
    with zipfile.ZipFile(path, "w") as made:
        for name in ("LICENSE", "blender_manifest.toml", "manual/index.html"):
            made.writestr(name, "")
    return path


def edit(path: Path, before: str, after: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert before in text
    path.write_text(text.replace(before, after), encoding="utf-8")


def small(path: Path) -> None:
    data = bytearray(path.read_bytes())
    data[16:24] = struct.pack(">II", 128, 128)
    path.write_bytes(data)


FAULTS = {
    "no changelog": (lambda tree: (tree / release.CHANGELOG).unlink(), "CHANGELOG.md: is missing"),
    "an old changelog": (lambda tree: edit(tree / release.CHANGELOG, f"## {version()}", "## 0.0.9"), f"its first section is not that of version {version()}"),
    "a small icon": (lambda tree: small(tree / release.ICON), "icon.png: 128 x 128 pixels; the platform asks for 256 x 256"),
    "a picture that is none": (lambda tree: (tree / release.FEATURED).write_text("none"), "0 x 0 pixels; the platform asks for 1920 x 1080"),
    "a long reason": (lambda tree: edit(tree / "blender_manifest.toml", "Read and write presets", "Read and write " + "presets " * 9), "at most 64"),
    "a sentence": (lambda tree: edit(tree / "blender_manifest.toml", "error stated", "error stated."), "tagline: ends in '.'"),
    "no tags": (lambda tree: edit(tree / "blender_manifest.toml", '"Material", "Render"', ""), "no tags"),
}


def test_this_tree_can_be_released(tree, archive):
    assert release.faults(tree, archive) == []


@pytest.mark.parametrize("fault", FAULTS)
def test_every_lack_is_a_line(tree, archive, fault):
    make, said = FAULTS[fault]
    make(tree)
    (line,) = release.faults(tree, archive)
    assert said in line


def test_a_zip_without_the_manual_or_of_another_version_is_refused(tree, archive):
    with zipfile.ZipFile(archive, "w") as made:
        made.writestr("LICENSE", "")
        made.writestr("blender_manifest.toml", "")
    assert release.faults(tree, archive) == [f"{archive.name}: has no manual/index.html"]
    other = archive.with_name("lamina-9.9.9.zip")
    shutil.copy(archive, other)
    assert release.faults(tree, other) == [f"lamina-9.9.9.zip: is not of version {version()}"]


def test_the_listing_gives_a_reason_for_every_permission():
    text = (ROOT / release.DESCRIPTION).read_text(encoding="utf-8")
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    assert all(f"*{name.title()}:*" in text for name in manifest["permissions"]) and "website" not in manifest


def test_notes_are_the_section_of_the_version():
    text = "# Changes\n\n## 2.0.0\n\n- new\n\n## 1.0.0\n\n- old\n"
    assert release.notes_of(text, "2.0.0") == "- new" and release.notes_of(text, "1.0.0") == ""
