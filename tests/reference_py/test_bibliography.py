# SPDX-License-Identifier: GPL-3.0-or-later
"""Every short key that a source file cites has its entry in reference_py/README.md."""

import re
from pathlib import Path

import lamina

ROOT = Path(lamina.__file__).parent
KEY = re.compile(r"\b(?:[A-Z][a-z]+){1,2}\d\d\b")


def test_cited_keys_are_in_the_bibliography_in_order():
    listed = re.findall(rf"^\| ({KEY.pattern}) \|", (ROOT / "reference_py/README.md").read_text(encoding="utf-8"), re.M)
    files = [path for folder in ("addon", "osl", "reference_py") for path in (ROOT / folder).rglob("*")]
    sources = [path for path in files if path.suffix in {".py", ".osl", ".h", ".json"}]
    cited = {key for path in sources for key in KEY.findall(path.read_text(encoding="utf-8"))}
    assert listed == sorted(cited)
