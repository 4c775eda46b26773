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
        raise LaminaError(f"{where}: not valid JSON at line {error.lineno} column {error.colno}: {error.msg}") from None
    except LaminaError as error:
        raise LaminaError(f"{where}: {error}") from None
    except UnicodeEncodeError as error:
        raise LaminaError(f"{where}: text holds half a character, {ascii(error.object[error.start])}") from None
    except RecursionError:
        raise LaminaError(f"{where}: not readable as JSON: nested too deeply") from None
    except ValueError as error:  # an integer of thousands of digits
        raise LaminaError(f"{where}: not readable as JSON: {error}") from None
    if _deeper_than(MAX_DEPTH, data):
        raise LaminaError(f"{where}: not readable as JSON: nested too deeply, more than {MAX_DEPTH} levels")
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
            raise LaminaError(f"{path}: {size} bytes is too large for a {what}; at most {MAX_FILE_BYTES}")
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise LaminaError(f"{path}: not UTF-8 text: {error.reason} at byte {error.start}") from None
    except (OSError, ValueError) as error:  # ValueError: a name with a null character
        raise LaminaError(f"{path}: cannot read {what}: {getattr(error, 'strerror', None) or error}") from None


def _no_constant(token: str):
    raise LaminaError(f"{token} is not a number that a file can hold")
