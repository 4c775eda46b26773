# SPDX-License-Identifier: GPL-3.0-or-later
"""The one exception that a user sees: its text is complete on one line, and keeps what a window needs to tell it in another language."""

from collections.abc import Callable, Iterable


class Sentence(str):
    """English text that remembers its template and the words in it: `Sentence("layer {number}", number=2)` is "layer 2".

    Words are what has no translation, such as names, numbers and choices, or sentences, or a LaminaError for its own.
    """

    template: str
    words: dict

    def __new__(cls, template: str, **words):
        """The sentence of a template that `str.format` fills in; without words it is the text itself."""
        words = {name: word.sentence if isinstance(word, LaminaError) else word for name, word in words.items()}
        made = super().__new__(cls, template.format(**words) if words else template)
        made.template, made.words = template, words
        return made

    def told(self, translate: Callable[[str], str]) -> str:
        """The text in the language of `translate`, which gets templates: its own, and those of sentences in it."""
        words = {name: word.told(translate) if isinstance(word, Sentence) else word for name, word in self.words.items()}
        return translate(self.template).format(**words) if words else translate(self.template)

    def packed(self) -> dict:
        """Itself for a line of JSON to another process; a word that is neither number nor sentence goes as text."""
        return {"template": self.template, "words": {name: _packed(word) for name, word in self.words.items()}}

    @classmethod
    def unpacked(cls, data: dict) -> "Sentence":
        """The sentence of what `packed` gave."""
        return cls(data["template"], **{name: cls.unpacked(word) if isinstance(word, dict) else word for name, word in data["words"].items()})


def joined(parts: Iterable[str], between: str = ", ") -> Sentence:
    """Texts in one, each of which keeps its words."""
    words = {f"part{number}": part for number, part in enumerate(parts)}
    return Sentence(between.join(f"{{{name}}}" for name in words), **words)


def _packed(word):
    if isinstance(word, Sentence):
        return word.packed()
    return word if isinstance(word, (bool, int, float)) else str(word)


class LaminaError(ValueError):
    """Bad input or a missing means. The message names the thing, the value and the choices.

    What an artist may meet has a template with its words apart, as `Sentence` takes them; `str` is the English line.
    """

    def __init__(self, template: str, **words):
        self.sentence = template if isinstance(template, Sentence) else Sentence(template, **words)
        super().__init__(str(self.sentence))

    def told(self, translate: Callable[[str], str]) -> str:
        """The message in the language of `translate`, as `Sentence.told`."""
        return self.sentence.told(translate)


def one_of(what: str, name: str, value, choices) -> object:
    """The value, where it is one of the choices. Raises LaminaError naming `what` it is an option of, its name, the value and the choices."""
    if value not in choices:
        raise LaminaError("{what}: unknown {name} {value!r}; choose {choices}", what=what, name=name, value=value, choices=", ".join(choices))
    return value
