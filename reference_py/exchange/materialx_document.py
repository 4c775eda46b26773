# SPDX-License-Identifier: GPL-3.0-or-later
"""The text of a MaterialX file as elements that know what is around them.

What somebody else wrote is read within limits: no document type (so no entities), not too large, not too deep.
"""

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from contextlib import contextmanager
from xml.parsers import expat

from ..errors import LaminaError

_MAX_DEPTH = 32
LINKS = ("nodename", "nodegraph", "interfacename", "output")
"""Attributes of an input that is linked."""


class Document:
    """A parsed file, with those that it includes. Elements are ElementTree's; attributes that hold for all below them are looked up with `nearest`."""

    def __init__(self, text: str, where: str):
        """Raises LaminaError in one line for what is no MaterialX."""
        self.where = where
        self.root = _root(text, where)
        self.roots = [self.root]
        self._instances: list[tuple[ElementTree.Element, ElementTree.Element, ElementTree.Element]] = []
        self._folders: dict[ElementTree.Element, str] = {}
        self._parents = {child: parent for parent in self.root.iter() for child in parent}

    def include(self, text: str, where: str, folder: str) -> None:
        """Have the elements of another file too, whose images are in `folder` below this one's. Raises LaminaError as a new one does."""
        root = _root(text, where)
        self.roots.append(root)
        self._folders[root] = f"{folder}/" if folder not in ("", ".") else ""
        self._parents |= {child: parent for parent in root.iter() for child in parent}

    def iter(self, tag: str | None = None) -> Iterator[ElementTree.Element]:
        """All elements, or those of a tag: of the file, then of each that it includes."""
        for root in self.roots:
            yield from root.iter(tag)

    @contextmanager
    def inside(self, node: ElementTree.Element) -> Iterator[ElementTree.Element | None]:
        """The graph that defines a node of a file's own kind, whose interface has this node's inputs meanwhile; None where there is no such graph."""
        definition = self._definition(node)
        graph = None
        if definition is not None and len(self._instances) < _MAX_DEPTH:
            written = next((i.get("nodegraph") for i in self.iter("implementation") if i.get("nodedef") == definition.get("name")), None)
            graph = next((g for g in self.iter("nodegraph") if g.get("nodedef") == definition.get("name") or (written and g.get("name") == written)), None)
        if graph is None or definition is None:
            yield None
            return
        self._instances.append((graph, node, definition))
        try:
            yield graph
        finally:
            self._instances.pop()

    def _definition(self, node: ElementTree.Element) -> ElementTree.Element | None:
        """Of the definitions of a kind the one that the node names, or else the first of its type, or else the first."""
        found = [d for d in self.iter("nodedef") if d.get("node") == node.tag and d.get("name")]
        named = [d for d in found if d.get("name") == node.get("nodedef")]
        typed = [d for d in found if any(o.tag == "output" and o.get("type") == node.get("type") for o in d)]
        return next(iter(named + typed + found), None)

    def is_definition(self, graph: ElementTree.Element) -> bool:
        """Whether a graph says what a kind of nodes is."""
        return bool(graph.get("nodedef")) or any(i.get("nodegraph") == graph.get("name") for i in self.iter("implementation"))

    def interface(self, element: ElementTree.Element) -> ElementTree.Element | None:
        """The input of the graph around an input's node that it is a name of; in a definition that of the node which is read.

        Where the node's says nothing it is the definition's.
        """
        scope, name = self.parent(self.parent(element)), element.get("interfacename")
        places = [scope] + [place for graph, node, definition in reversed(self._instances) if graph is scope for place in (node, definition)]
        found = [i for place in places for i in place if i.tag == "input" and i.get("name") == name]
        return next((i for i in found if any(i.get(key) for key in LINKS) or i.get("value", "").strip()), found[-1] if found else None)

    def parent(self, element: ElementTree.Element) -> ElementTree.Element:
        """The element around it; the root's is itself."""
        return self._parents.get(element, element)

    def nearest(self, element: ElementTree.Element, attribute: str) -> str:
        """An attribute of the element or of the nearest one around it that has it; empty where none has."""
        while attribute not in element.attrib and element in self._parents:
            element = self._parents[element]
        return element.get(attribute, "")

    def prefixed(self, element: ElementTree.Element, attribute: str) -> str:
        """All values of an attribute of the elements around it, outermost first, joined, as file prefixes are; before them an included file's folder."""
        text = element.get(attribute, "")
        while element in self._parents:
            element = self._parents[element]
            text = element.get(attribute, "") + text
        return self._folders.get(element, "") + text

    def named(self, name: str, scope: ElementTree.Element) -> ElementTree.Element | None:
        """The element of a name among the children of `scope`, or else of the file, or of one that it includes."""
        for place in (scope, *self.roots):
            found = next((child for child in place if child.get("name") == name and child.tag not in ("input", "output")), None)
            if found is not None:
                return found
        return None


def _root(text: str, where: str) -> ElementTree.Element:
    root = _parsed(text, where)
    if root.tag != "materialx":
        raise LaminaError("{where}: not a MaterialX file: its root is <{tag}>, not <materialx>", where=where, tag=root.tag[:40])
    return root


def _parsed(text: str, where: str) -> ElementTree.Element:
    builder, parser = ElementTree.TreeBuilder(), expat.ParserCreate()
    depth = 0

    def start(tag, attributes):
        nonlocal depth
        depth += 1
        if depth > _MAX_DEPTH:
            raise LaminaError("{where}: nested too deeply, more than {most} levels", where=where, most=_MAX_DEPTH)
        builder.start(tag, attributes)

    def end(tag):
        nonlocal depth
        depth -= 1
        builder.end(tag)

    def refuse(*_):
        raise LaminaError("{where}: has a document type; entities are not read, so remove its <!DOCTYPE ...>", where=where)

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(text.encode("utf-8"), True)
    except expat.ExpatError as error:
        message = expat.errors.messages[error.code]
        raise LaminaError(
            "{where}: not valid XML at line {line} column {column}: {reason}", where=where, line=error.lineno, column=error.offset, reason=message
        ) from None
    except (ValueError, LookupError, UnicodeError) as error:
        if isinstance(error, LaminaError):
            raise
        raise LaminaError("{where}: not readable as XML: {error}", where=where, error=error) from None
    return builder.close()
