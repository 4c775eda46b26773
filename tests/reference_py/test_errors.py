# SPDX-License-Identifier: GPL-3.0-or-later
"""An error is an English line to a command line, and a template with words to a window."""

import json
import pickle
from pathlib import Path

import numpy as np

from lamina.reference_py.errors import LaminaError, Sentence, one_of

GERMAN = {"{what}: unknown {name} {value!r}": "{what}: unbekannt: {name} {value!r}", "layer {number}": "Schicht {number}", "gone": "weg"}


def german(text: str) -> str:
    return GERMAN.get(text, text)


def test_it_is_english_and_tells_its_template_and_those_in_it_anew():
    error = LaminaError("{what}: unknown {name} {value!r}", what=Sentence("layer {number}", number=2), name="kind", value="{x}")
    assert str(error) == "layer 2: unknown kind '{x}'"
    assert error.told(german) == "Schicht 2: unbekannt: kind '{x}'"
    outer = LaminaError("{where}: {error}", where="a.json", error=error)
    assert str(outer) == f"a.json: {error}" and outer.told(german) == f"a.json: {error.told(german)}"


def test_a_text_without_words_stays_as_it_is_and_may_have_braces():
    assert str(LaminaError("gone")) == "gone" and LaminaError("gone").told(german) == "weg"
    assert str(LaminaError("{x} is no set")) == LaminaError("{x} is no set").told(german) == "{x} is no set"


def test_a_name_that_is_a_word_elsewhere_is_not_translated():
    assert Sentence("layer {number}", number="gone").told(german) == "Schicht gone"


def test_it_survives_a_process_and_a_second_raise():
    error = pickle.loads(pickle.dumps(LaminaError("layer {number}", number=1)))
    assert str(error) == "layer 1" and error.told(german) == "Schicht 1"
    assert LaminaError(error.sentence).told(german) == "Schicht 1"


def test_a_line_of_json_keeps_it_with_the_sentences_in_it():
    words = {"file": Path("a"), "count": 3, "of": np.float64(0.25), "what": Sentence("layer {number}", number=2)}
    sent = Sentence("{file}: {count:d} of {of:.1f}: {what}", **words)
    got = Sentence.unpacked(json.loads(json.dumps(sent.packed())))
    assert got == sent == "a: 3 of 0.2: layer 2" and got.told(german) == "a: 3 of 0.2: Schicht 2"


def test_one_of_gives_what_is_known():
    assert one_of("export", "format", "a", ("a", "b")) == "a"
