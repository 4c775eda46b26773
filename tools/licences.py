# SPDX-License-Identifier: GPL-3.0-or-later
"""Print the licence of every package that the development environment pins, as the package itself states it.

    licences.py       exit code 1 if a package does not say; it is looked for in all environments of this checkout

None of them is part of the extension, which needs what Blender brings along and nothing else.
"""

import re
import sys
from importlib.metadata import PackageNotFoundError, distributions
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def pinned() -> dict[str, set[str]]:
    """Name: versions, over all requirement files."""
    found: dict[str, set[str]] = {}
    for file in sorted((ROOT / "requirements").glob("*.txt")):
        for name, number in re.findall(r"^([\w.-]+)==(\S+)", file.read_text(encoding="utf-8"), re.MULTILINE):
            found.setdefault(name, set()).add(number)
    return found


def licence(name: str) -> str:
    """What the installed package says; empty when it says nothing. Raises PackageNotFoundError."""
    folders = [*sys.path, *map(str, sorted(ROOT.glob(".venv*/lib/python*/site-packages")))]
    found = next(iter(distributions(name=name, path=folders)), None)
    if found is None:
        raise PackageNotFoundError(name)
    data = found.metadata
    if said := data.get("License-Expression"):
        return said
    classes = [c.rpartition(" :: ")[2] for c in data.get_all("Classifier", []) if c.startswith("License ::")]
    if classes := [c for c in classes if c != "OSI Approved"]:
        return ", ".join(classes)
    return (data.get("License") or "").strip().splitlines()[0][:60] if data.get("License") else ""


def main() -> int:
    silent = []
    for name, versions in sorted(pinned().items()):
        try:
            said = licence(name)
        except PackageNotFoundError:
            said = "not installed here (another Python's)"
        if not said:
            silent.append(name)
        print(f"{name:20} {', '.join(sorted(versions)):18} {said or '?'}")
    print(f"{len(pinned())} packages, {len(silent)} of them without a licence{': ' + ', '.join(silent) if silent else ''}")
    return 1 if silent else 0


if __name__ == "__main__":
    sys.exit(main())
