# SPDX-License-Identifier: GPL-3.0-or-later
"""JSON that somebody else wrote: read within limits, and whatever is wrong with it said in one line."""

import json
import os
from pathlib import Path

from ..errors import LaminaError

MAX_FILE_BYTES = 4_000_000
# More than any file of ours needs, and less than Python can take when it writes them again.
MAX_DEPTH = 100


def parse_json(text: str, where: str):
    """The value that a JSON text holds. Raises LaminaError naming `where`, the place and what is wrong."""
    try:
        data = json.loads(text, parse_constant=_no_constant)
        json.dumps(data, ensure_ascii=False).encode()
    except json.JSONDecodeError as error:
        raise LaminaError(
            "{where}: not valid JSON at line {line} column {column}: {reason}", where=where, line=error.lineno, column=error.colno, reason=error.msg
        ) from None
    except LaminaError as error:
        raise LaminaError("{where}: {error}", where=where, error=error) from None
    except UnicodeEncodeError as error:
        raise LaminaError("{where}: text holds half a character, {letter}", where=where, letter=ascii(error.object[error.start])) from None
    except RecursionError:
        raise LaminaError("{where}: not readable as JSON: nested too deeply", where=where) from None
    except ValueError as error:  # an integer of thousands of digits
        raise LaminaError("{where}: not readable as JSON: {error}", where=where, error=error) from None
    if _deeper_than(MAX_DEPTH, data):
        raise LaminaError("{where}: not readable as JSON: nested too deeply, more than {most} levels", where=where, most=MAX_DEPTH)
    return data


def _deeper_than(limit: int, data) -> bool:
    level = [data]
    for _ in range(limit):
        level = [inner for v in level if isinstance(v, (dict, list)) for inner in (v.values() if isinstance(v, dict) else v)]
    return any(isinstance(v, (dict, list)) for v in level)


def read_text(path: str | os.PathLike, what: str) -> str:
    """The text of a small UTF-8 file. Raises LaminaError; `what` says what it should be, such as "stack file"."""
    path = Path(path)
    try:
        size = path.stat().st_size
        if size > MAX_FILE_BYTES:
            raise LaminaError("{path}: {size} bytes is too large for a {what}; at most {most}", path=path, size=size, what=what, most=MAX_FILE_BYTES)
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise LaminaError("{path}: not UTF-8 text: {reason} at byte {start}", path=path, reason=error.reason, start=error.start) from None
    except (OSError, ValueError) as error:  # ValueError: a name with a null character
        raise LaminaError("{path}: cannot read {what}: {reason}", path=path, what=what, reason=getattr(error, "strerror", None) or error) from None


def _no_constant(token: str):
    raise LaminaError("{token} is not a number that a file can hold", token=token)
