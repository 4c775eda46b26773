# SPDX-License-Identifier: GPL-3.0-or-later
"""What pyproject.toml cannot say: the version stands in Blender's manifest, and this folder is the package `lamina`."""

import tomllib
from pathlib import Path

from setuptools import find_packages, setup

manifest = tomllib.loads((Path(__file__).parent / "blender_manifest.toml").read_text(encoding="utf-8"))
parts = find_packages(include=["addon*", "reference_py*", "demo_blend*"])

setup(
    version=manifest["version"],
    package_dir={"lamina": "."},
    packages=["lamina"] + [f"lamina.{part}" for part in parts],
)
