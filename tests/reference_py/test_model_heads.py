# SPDX-License-Identifier: GPL-3.0-or-later
"""The head of each model's file: its table of options is what the class accepts, and its example is what it prints."""

import doctest
import inspect
import sys
from importlib import import_module
from pathlib import Path

import pytest

from lamina.reference_py import registry
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.lobes.methods import make_lobe_set
from lamina.reference_py.material import presets
from lamina.reference_py.registry import MODELS, make_model

ROOT = Path(registry.__file__).parent
WITH_EXAMPLES = sorted(
    ".".join(("lamina.reference_py", *path.relative_to(ROOT).with_suffix("").parts)).removesuffix(".__init__")
    for path in ROOT.rglob("*.py")
    if ">>> " in path.read_text(encoding="utf-8")
)
STACK = presets.load("glazed_mug")
NO_OPTIONS = "Options: none."
COLUMNS = ["option", "default", "meaning"]
# No value that an option may have.
UNKNOWN = "?"


def head_of(name):
    return sys.modules[MODELS[name].__module__].__doc__


def cells_of(line):
    return [cell.strip() for cell in line.split("|", 2)]


def table_of(head):
    """{option: [default, meaning]} of a head; a row without a name goes on with the meaning above. None without a table."""
    lines = head.splitlines()
    if NO_OPTIONS in lines:
        return {}
    start = next((i for i, line in enumerate(lines) if cells_of(line) == COLUMNS), None)
    if start is None:
        return None
    rows = {}
    for line in lines[start + 2 :]:  # below the dashes
        if not line:
            break
        option, default, meaning = cells_of(line)
        if option:
            rows[option] = [default, meaning]
        else:
            rows[list(rows)[-1]][1] += f" {meaning}"
    return rows


def refused(name, **options):
    with pytest.raises(LaminaError) as caught:
        make_model(name, STACK, **options)
    return str(caught.value)


def accepted(name):
    """Names of the options of a model, by what it says to one that it does not know."""
    said = refused(name, **{UNKNOWN: UNKNOWN})
    return [] if said.endswith("it has none") else said.split("choose ")[1].split(", ")


def default_of(name, option):
    parameter = inspect.signature(MODELS[name].__init__).parameters.get(option)
    if parameter is not None:
        return parameter.default
    if name == "closure_model":
        return inspect.signature(make_lobe_set).parameters[option].default
    model = make_model(name, STACK)
    return model.options[option] if isinstance(model.options, dict) else getattr(model, option)


def faults(name, head):
    """What the table of a head does not say of a model, or says wrongly."""
    table, options = table_of(head), accepted(name)
    if table is None:
        return ["no table"]
    found = [f"{option}: not in the table" for option in options if option not in table]
    found += [f"{option}: not an option" for option in table if option not in options]
    for option in set(options) & set(table):
        default, meaning = table[option]
        if default != str(default_of(name, option)).lower():
            found.append(f"{option}: the default is {default_of(name, option)}")
        for choice in refused(name, **{option: UNKNOWN}).split("choose ")[1].split(", "):
            if choice not in meaning:
                found.append(f"{option}: the meaning does not name {choice!r}")
    return found


@pytest.mark.parametrize("name", MODELS)
def test_the_table_of_options_is_what_the_model_accepts(name):
    assert faults(name, head_of(name)) == []


@pytest.mark.parametrize("name", MODELS)
def test_every_head_has_an_example_of_at_most_five_lines(name):
    example = head_of(name).split("\n>>> ", 1)[1]
    assert f'make_model("{name}"' in example and len(example.strip().splitlines()) <= 5


@pytest.mark.parametrize("name", [name for name in MODELS if accepted(name)])
def test_what_a_head_lacks_is_noticed(name):
    head = head_of(name)
    option, (default, _) = list(table_of(head).items())[-1]
    row = next(line for line in head.splitlines() if cells_of(line)[0] == option)
    assert f"{option}: not in the table" in faults(name, head.split(row)[0])
    assert f"other {option}: not an option" in faults(name, head.replace(row, f"other {row}"))
    assert faults(name, head.replace(row, row.replace(f"| {default}", "| other", 1))) == [f"{option}: the default is {default}"]


@pytest.fixture(scope="module")
def imports():
    """The names that the registry's head says examples need."""
    test = doctest.DocTestParser().get_doctest(registry.__doc__, {}, "registry", registry.__file__, 0)
    doctest.DocTestRunner().run(test, clear_globs=False)
    return test.globs


@pytest.mark.parametrize("module", WITH_EXAMPLES)
def test_examples_print_what_they_say(module, imports):
    result = doctest.testmod(import_module(module), extraglobs=imports)
    assert result.attempted > 0 and result.failed == 0
