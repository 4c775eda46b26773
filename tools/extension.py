# SPDX-License-Identifier: GPL-3.0-or-later
"""Build and validate the extension with the tool that Blender itself uses, from the bpy wheel beside this Python.

extension.py build FOLDER     write FOLDER/lamina-VERSION.zip
extension.py validate PATH    check a zip, or a source folder
"""

import argparse
import importlib.util
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def blender_scripts() -> Path:
    """The `scripts` folder of the bpy wheel, found without importing bpy."""
    spec = importlib.util.find_spec("bpy")
    if spec is None:
        sys.exit(f"{sys.executable} has no bpy: run `make zip`, which sets it up.")
    return next(Path(spec.origin).parent.glob("[0-9]*/scripts"))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("action", choices=["build", "validate"])
    parser.add_argument("path", type=Path, metavar="FOLDER_OR_ZIP")
    arguments = parser.parse_args()

    scripts = blender_scripts()
    tags = f"--valid-tags={scripts / 'modules/_bpy_internal/extensions/tags.py'}"
    if arguments.action == "build":
        arguments.path.mkdir(parents=True, exist_ok=True)
        command = ["build", f"--source-dir={ROOT}", f"--output-dir={arguments.path}", tags]
    else:
        command = ["validate", str(arguments.path), tags]
    return subprocess.run([sys.executable, scripts / "addons_core/bl_pkg/cli/blender_ext.py", *command]).returncode


if __name__ == "__main__":
    sys.exit(main())
