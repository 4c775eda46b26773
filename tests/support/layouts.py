# SPDX-License-Identifier: GPL-3.0-or-later
"""A stand-in for Blender's layout, which exists in a window only: it notes what is drawn where, and how many lines that takes."""

from types import SimpleNamespace


class Recorder:
    """A column, or a row, of what was drawn into it, in order: (what, word) pairs and further recorders. `operators`, and the `icons` of labels and
    properties, are those of all of it."""

    def __init__(self, is_row: bool = False):
        self.is_row, self.parts, self.operators, self.icons = is_row, [], [], []

    @property
    def height(self) -> int:
        """Lines of it."""
        heights = [part.height if isinstance(part, Recorder) else part[2] for part in self.parts]
        return max(heights, default=0) if self.is_row else sum(heights)

    @property
    def words(self) -> list[tuple[str, str]]:
        """What was drawn, with its first word, in order."""
        return [word for part in self.parts for word in (part.words if isinstance(part, Recorder) else [part[:2]])]

    def texts(self) -> list[str]:
        """Every text that can be read, tooltips of notes too."""
        return [text for part in self.parts for text in (part.texts() if isinstance(part, Recorder) else part[3]())]

    def _note(self, what: str, name: str, lines: int = 1, texts=list):
        self.parts.append((what, name, lines, texts))

    def _inner(self, is_row: bool):
        inner = Recorder(is_row)
        inner.operators, inner.icons = self.operators, self.icons
        self.parts.append(inner)
        return inner

    def row(self, **_options):
        return self._inner(True)

    split = row

    def column(self, **_options):
        return self._inner(False)

    box = column

    def panel(self, name, default_closed=False):
        header, body = self._inner(True), self._inner(False)
        header._note("panel", name)
        return header, body

    def label(self, text="", icon="NONE", **_options):
        self.icons.append(icon)
        self._note("label", text, texts=lambda: [text])

    def progress(self, text="", **_options):
        self._note("progress", text, texts=lambda: [text])

    def operator(self, name, text="", icon_value=0, **_options):
        properties = SimpleNamespace(text="", icon=icon_value)
        self._note("operator", name, texts=lambda: [text, properties.text])
        self.operators.append((name, properties))
        return properties

    def prop(self, _owner, name, text="", icon="NONE", **_options):
        self.icons.append(icon)
        self._note("prop", name, texts=lambda: [text])

    def template_list(self, name, *_arguments, rows, **_options):
        self._note("list", name, rows + 1)

    def template_node_view(self, _tree, _node, socket):
        self._note("socket", socket.name, texts=lambda: [socket.name])

    def menu(self, name, text="", **_options):
        self._note("menu", name, texts=lambda: [text])

    def popover(self, name, text="", **_options):
        self._note("popover", name, texts=lambda: [text])

    def operator_menu_enum(self, name, _prop, text="", **_options):
        self._note("operator_menu_enum", name, texts=lambda: [text])

    def separator(self, **_options):
        pass
