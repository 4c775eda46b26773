# SPDX-License-Identifier: GPL-3.0-or-later
"""Put the numbers of the committed tables into the documents.

    python -m lamina.study.numbers [--check]

A document has a number between two comments, which Markdown does not show: `<!--n:NAME-->65 %<!--/n-->`; `named_numbers` says what
a name stands for. With --check nothing is written, and the exit code is 1 where a document differs from the tables.
"""

import argparse
import re
import sys
from collections.abc import Sequence
from pathlib import Path

from ..reference_py.atomic import write_text
from ..reference_py.errors import LaminaError
from .named_numbers import NUMBERS
from .stamp import ROOT

DOCUMENTS = (ROOT / "README.md", ROOT / "figures" / "README.md", *sorted((ROOT / "docs").glob("**/*.md")))
_NUMBER = re.compile(r"<!--n:(?P<name>[^<>]*)-->(?P<value>.*?)<!--/n-->", re.DOTALL)
_MARKER = re.compile(r"<!--/?n\b.*?-->")


def names_in(text: str) -> list[str]:
    """The names of a document's numbers. Raises LaminaError on an unknown one, and on a marker without its other one."""
    found = [match["name"] for match in _NUMBER.finditer(text)]
    for name in found:
        if name not in NUMBERS:
            raise LaminaError(f"unknown number {name!r}; choose {', '.join(NUMBERS)}")
    alone = _MARKER.findall(_NUMBER.sub(lambda match: match["value"], text))
    if alone:
        raise LaminaError(f"{alone[0]} has no other end; a number is <!--n:NAME-->65 %<!--/n-->")
    return found


def filled(text: str) -> str:
    """The document with every number as the tables have it."""
    names_in(text)
    return _NUMBER.sub(lambda match: f"<!--n:{match['name']}-->{NUMBERS[match['name']]()}<!--/n-->", text)


def differences(text: str) -> list[str]:
    """What is not as the tables have it, a line for each number."""
    names_in(text)
    numbers = [(match["name"], match["value"], NUMBERS[match["name"]]()) for match in _NUMBER.finditer(text)]
    return [f"{name} is {value!r}, in the tables {right!r}" for name, value, right in numbers if value != right]


def main(arguments: Sequence[str] | None = None, documents: Sequence[Path] = DOCUMENTS) -> int:
    parser = argparse.ArgumentParser(prog="python -m lamina.study.numbers", description="put the numbers of figures/ into the documents")
    parser.add_argument("--check", action="store_true", help="write nothing; exit code 1 where a document differs from the tables")
    check = parser.parse_args(arguments).check
    differs = 0
    for path in documents:
        text = path.read_text(encoding="utf-8")
        try:
            found = differences(text)
        except LaminaError as error:
            print(f"{path}: {error}", file=sys.stderr)
            return 2
        differs += len(found)
        for each in found:
            print(f"{path}: {each}")
        if found and not check:
            write_text(path, filled(text))
    return 1 if check and differs else 0


if __name__ == "__main__":
    sys.exit(main())
