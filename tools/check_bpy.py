# SPDX-License-Identifier: GPL-3.0-or-later
"""Check that this Python can start Blender (`import bpy`); if not, say in one line which Debian packages to install.

`check_bpy.py --packages` prints the names of the missing packages and nothing else.
"""

import importlib.util
import shutil
import subprocess
import sys

DEBIAN_PACKAGES = {
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libICE.so.6": "libice6",
    "libSM.so.6": "libsm6",
    "libX11.so.6": "libx11-6",
    "libXext.so.6": "libxext6",
    "libXfixes.so.3": "libxfixes3",
    "libXi.so.6": "libxi6",
    "libXrender.so.1": "libxrender1",
    "libXt.so.6": "libxt6",
    "libXxf86vm.so.1": "libxxf86vm1",
    "libgomp.so.1": "libgomp1",
    "libstdc++.so.6": "libstdc++6",
    "libuuid.so.1": "libuuid1",
    "libxkbcommon.so.0": "libxkbcommon0",
}


def missing_libraries() -> list[str]:
    """The system libraries that the bpy wheel links against and the loader cannot find (found without importing bpy)."""
    spec = importlib.util.find_spec("bpy")
    if spec is None:
        sys.exit(f"The Python package bpy is missing from {sys.prefix}: remove that folder and run make again.")
    if shutil.which("ldd") is None:  # not Linux: the import below is the only check
        return []
    listing = subprocess.run(["ldd", spec.origin], capture_output=True, text=True).stdout
    return sorted({line.split()[0] for line in listing.splitlines() if "not found" in line and "=>" in line})


def main() -> None:
    missing = missing_libraries()
    packages = [DEBIAN_PACKAGES[name] for name in missing if name in DEBIAN_PACKAGES]
    if "--packages" in sys.argv[1:]:
        print(*packages)
        return
    if missing:
        unknown = [name for name in missing if name not in DEBIAN_PACKAGES]
        remedy = f"apt-get install {' '.join(packages)}" if packages else "install them"
        if unknown and packages:
            remedy += f" and what holds {', '.join(unknown)}"
        sys.exit(f"Blender (bpy) needs system libraries that are missing: {', '.join(missing)}. On Debian: {remedy}")
    result = subprocess.run([sys.executable, "-c", "import bpy"], capture_output=True, text=True)
    if result.returncode:
        reason = (result.stderr.strip() or f"exit status {result.returncode}").splitlines()[-1]
        sys.exit(f"Blender (bpy) does not start: {reason}")


if __name__ == "__main__":
    main()
