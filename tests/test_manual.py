# SPDX-License-Identifier: GPL-3.0-or-later
"""The manual: every page is listed, every link leads somewhere, every parameter has its strip, and README stays short."""

import re
from pathlib import Path

import pytest

import lamina
from lamina.reference_py.material.schema import SCHEMA
from lamina.study.charts.sliders import OF_THE_BASE, STRIPS, stack_of, words

ROOT = Path(lamina.__file__).resolve().parent
DOCS = ROOT / "docs"
PAGES = (ROOT / "README.md", *sorted(DOCS.glob("*.md")))
_LINK = re.compile(r"\]\((?!https?:|mailto:)([^)\s]+)\)")
_HEADING = re.compile(r"^#+ (.*)$", re.M)


def outside_code(text: str) -> str:
    return re.sub(r"```.*?```|`[^`\n]*`", "", text, flags=re.S)


def anchor(heading: str) -> str:
    """The name that a heading gets on a repository's page and on the site."""
    kept = re.sub(r"[^\w\- ]", "", re.sub(r"<!--.*?-->|`", "", heading).lower())
    return kept.strip().replace(" ", "-")


def broken_links(page: Path, text: str) -> list[str]:
    """Links of a page that lead to no file, or to no heading of it."""
    found = []
    for target in _LINK.findall(outside_code(text)):
        name, _, part = target.partition("#")
        path = (page.parent / name).resolve() if name else page
        if not path.exists():
            found.append(target)
        elif part and part not in map(anchor, _HEADING.findall(path.read_text(encoding="utf-8"))):
            found.append(target)
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_every_link_leads_somewhere(page):
    assert broken_links(page, page.read_text(encoding="utf-8")) == []


def test_a_broken_link_is_found():
    assert broken_links(PAGES[1], "[a](none.md) [b](index.md#no-such) [c](index.md)") == ["none.md", "index.md#no-such"]


def test_every_page_is_in_the_list_of_the_site():
    listed = re.findall(r"- ([\w-]+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.M)
    assert sorted(listed) == [path.name for path in PAGES[1:]]


def test_readme_is_short_and_names_every_page():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 120
    missing = [path.name for path in PAGES[1:] if path.name != "index.md" and f"docs/{path.name}" not in text]
    assert missing == []


def kinds():
    return (*SCHEMA.layers.values(), *SCHEMA.bases.values())


def parameters():
    return {p.name: p for kind in kinds() for group in (kind, *kind.features) for p in group.parameters}


def test_every_parameter_has_a_strip_and_its_words():
    page = (DOCS / "sliders.md").read_text(encoding="utf-8")
    headings = _HEADING.findall(page)
    for name, parameter in parameters().items():
        assert parameter.label in headings, name
        if name != "normal":  # to be linked; it has no value to drag
            assert f"pictures/slider_{name}.png" in page and len(STRIPS[name][2]) in (2, 5), name
    assert set(STRIPS) == set(parameters()) - {"normal"}


@pytest.mark.parametrize("name", STRIPS)
def test_a_strip_changes_its_parameter_alone(name):
    stacks = [stack_of(name, value).to_dict() for value in STRIPS[name][2]]
    where = [stack["base"] if name in OF_THE_BASE else stack["layers"][0] for stack in stacks]
    assert len({words(place[name]) for place in where}) == len(stacks)
    rest = [{**place, name: None} for place in where]
    assert all(other == rest[0] for other in rest)
