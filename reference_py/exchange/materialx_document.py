# SPDX-License-Identifier: GPL-3.0-or-later
"""The text of a MaterialX file as elements that know what is around them.

What somebody else wrote is read within limits: no document type (so no entities), not too large, not too deep.
"""

import xml.etree.ElementTree as ElementTree
from xml.parsers import expat

from ..errors import LaminaError

_MAX_DEPTH = 32


class Document:
    """A parsed file. Elements are ElementTree's; attributes that hold for all below them are looked up with `nearest`."""

    def __init__(self, text: str, where: str):
        """Raises LaminaError in one line for what is no MaterialX."""
        self.where = where
        self.root = _parsed(text, where)
        if self.root.tag != "materialx":
            raise LaminaError("{where}: not a MaterialX file: its root is <{tag}>, not <materialx>", where=where, tag=self.root.tag[:40])
        self._parents = {child: parent for parent in self.root.iter() for child in parent}

    def parent(self, element: ElementTree.Element) -> ElementTree.Element:
        """The element around it; the root's is itself."""
        return self._parents.get(element, element)

    def nearest(self, element: ElementTree.Element, attribute: str) -> str:
        """An attribute of the element or of the nearest one around it that has it; empty where none has."""
        while attribute not in element.attrib and element is not self.root:
            element = self._parents[element]
        return element.get(attribute, "")

    def prefixed(self, element: ElementTree.Element, attribute: str) -> str:
        """All values of an attribute of the elements around it, outermost first, joined, as file prefixes are."""
        text = element.get(attribute, "")
        while element is not self.root:
            element = self._parents[element]
            text = element.get(attribute, "") + text
        return text

    def named(self, name: str, scope: ElementTree.Element) -> ElementTree.Element | None:
        """The element of a name among the children of `scope`, or else of the file."""
        for place in (scope, self.root):
            found = next((child for child in place if child.get("name") == name and child.tag not in ("input", "output")), None)
            if found is not None:
                return found
        return None


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
