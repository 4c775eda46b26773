# SPDX-License-Identifier: GPL-3.0-or-later
"""The manual's first hour with mouse and keys: convert there and back, a preset, layers, undo, rust by a mask, a wooden table."""

import struct
import time
import zlib
from pathlib import Path

from driver import DOT, MIDDLE, ROW, VALUE, Window

# Where menus are opened, in buttons below that which removes a layer.
ADD, SPECIALS = -1.0, 1.4
# Pixels from a number's dot to Image Texture in the menu that the dot opens, whose rows are so far apart.
_IMAGE_TEXTURE, _MENU_ROW = (64, 232), 23
# Pixels from a color's dot to the picker's field for its hexadecimal digits.
_HEX = (114, -29)
# In the window that asks for a file, from its left and top the folder, from its right and bottom the button.
_FOLDER, _OPEN = (576, 20), (-72, -20)
_STAIN = "#B5651D"


def told(text: str) -> None:
    print(text, flush=True)


def use(window: Window) -> None:
    """The session; every step says what it proved."""
    panel = window.wait_for("the window", lambda s: s["ready"])["panel"]
    x = (panel["left"] + panel["right"]) // 2
    convert(window)
    # below the slots and their buttons, one of which would make a material of another name
    for y in range(panel["top"] + 10 * ROW + 8, panel["top"] + 16 * ROW, ROW // 2):
        window.click(x, y)
        time.sleep(0.5)
        window.key("Down")
        window.key("Return")
        try:
            state = window.wait_for("a preset", lambda s: s["layers"], patience=2.5)
            break
        except AssertionError:
            window.key("Escape")
    else:
        raise AssertionError("no menu of presets in the panel")
    assert state["name"] == state["stack"], state
    told(f"preset: {state['stack']}, {len(state['layers'])} layer(s)")
    window.picture("preset")

    first = state["layers"]
    for number, letter in enumerate("df", 1):  # Dielectric, Frost: a menu takes the letters that it underlines
        state = add_layer(window, letter, len(first) + number)
    assert state["layers"][2:] == first and state["active"] == 0, state
    told(f"add: {', '.join(state['layers'])}")
    window.picture("added")

    before = state["layers"]
    state = move_down(window, before)
    assert state["layers"] == [before[1], before[0], *before[2:]] and state["active"] == 1, state
    told(f"move: {', '.join(state['layers'])}")

    select_rows(window, state)
    told("select: the row that was clicked, and no material was evaluated")

    window.mouse("mousemove", x, panel["bottom"] - 10)
    for undone, wanted in ((1, before), (2, before[1:]), (3, first)):
        window.key("ctrl+z")
        window.wait_for(f"undo {undone}", lambda s, w=wanted: s["layers"] == w)
    told("undo: three steps back")
    for redone, wanted in enumerate((before[1:], before, state["layers"]), 1):
        window.key("ctrl+shift+z")
        window.wait_for(f"redo {redone}", lambda s, w=wanted: s["layers"] == w)
    told("redo: three steps forth")
    assert window.state()["findings"] == [], window.state()
    rust_by_a_mask(window)
    window.picture("done")
    wooden_table(window)


def convert(window: Window) -> None:
    """Blender's own new material to Lamina and a Principled copy of that; then the object has none again."""
    window.click(*window.find("material.new", MIDDLE))
    window.wait_for("a new material", lambda s: s["name"])
    window.click(*window.find("lamina.convert_principled", MIDDLE))
    state = window.wait_for("what it is as layers", lambda s: s["layers"])
    window.key("Escape")  # the report
    told(f"convert: {', '.join(state['layers'])}")
    before = state["materials"]
    pick(window, SPECIALS, "LAMINA_MT_exchange", "lamina.principled_copy()")
    state = window.wait_for("a Principled copy", lambda s: len(s["materials"]) > len(before))
    window.key("Escape")
    told(f"back: {', '.join(set(state['materials']) - set(before))}")
    window.picture("converted")
    window.click(*window.find("material_slot_remove"))
    window.wait_for("an object without a material", lambda s: not s["name"])


def rust_by_a_mask(window: Window) -> None:
    """The ready layer Rust, which has a mask of its own, and a plain layer that gets one from the menu."""
    before = window.state()["layers"]
    pick(window, ADD, "layer_add_ready(ready='rust')")
    state = window.wait_for("rust", lambda s: len(s["layers"]) == len(before) + 1)
    assert state["masked"][state["active"]], state
    told(f"rust by its mask: {', '.join(state['layers'])}")
    pick(window, ADD, "layer_add(kind='dielectric')")
    state = window.wait_for("a plain layer", lambda s: len(s["layers"]) == len(before) + 2)
    assert not state["masked"][state["active"]], state
    pick(window, SPECIALS, "LAMINA_MT_add_mask", "edges")
    window.wait_for("its mask", lambda s: s["masked"][s["active"]])
    told(f"a mask: {', '.join(state['layers'])}")


def pick(window: Window, below: float, *commands: str) -> None:
    """Open a menu of the column beside the list, so many buttons below the one that removes a layer, and choose; thrice, as a busy machine may miss a click."""
    for _ in range(3):
        x, y = window.find("lamina.layer_remove")
        window.click(x, y + below * ROW)
        time.sleep(2.0)
        if window.pick(*commands):
            return
        for _ in range(3):
            window.key("Escape")
    raise AssertionError(f"no menu has {commands[-1]}")


def add_layer(window: Window, letter: str, count: int) -> dict:
    """Pick from the menu above the button that removes a layer. The panel may have moved, as when a bake is done, so thrice."""
    for _ in range(3):
        x, y = window.find("lamina.layer_remove")
        window.click(x, y - ROW)
        time.sleep(2.0)
        window.key(letter)
        try:
            return window.wait_for("a new layer", lambda s: len(s["layers"]) == count, patience=6.0)
        except AssertionError:
            window.key("Escape")
    raise AssertionError(f"no layer was added; the last state: {window.state()}")


def select_rows(window: Window, before: dict) -> None:
    """Click rows of the list, left of its buttons, of which the one that removes a layer is as high as the second row."""
    x, y = window.find("lamina.layer_remove")
    time.sleep(1.0)
    evaluated = window.state()["evaluated"]
    for row in (2, 0, 1):
        window.click(before["panel"]["left"] + 100, y + (row - 1) * ROW)
        window.wait_for(f"row {row}", lambda s, r=row: s["active"] == r, patience=15.0)
    assert window.state()["evaluated"] == evaluated, (evaluated, window.state())


def move_down(window: Window, before: list[str]) -> dict:
    """Click the button that moves a layer down; thrice, as a busy machine may miss a click."""
    for _ in range(3):
        window.click(*window.find("lamina.layer_move(direction='DOWN')"))
        try:
            return window.wait_for("a layer that moved", lambda s: s["layers"] != before, patience=15.0)
        except AssertionError:
            continue
    raise AssertionError(f"no layer moved; the last state: {window.state()}")


def wooden_table(window: Window) -> None:
    """A varnish over wood, whose color and roughness are pictures, with a stain below; as the manual has it."""
    window.click(*window.find("material_slot_remove"))
    window.wait_for("an object without a material", lambda s: not s["name"])
    x, y = window.find("lamina.new_material", MIDDLE)
    window.click(x, y - ROW)
    time.sleep(2.0)
    assert window.pick("apply_preset(preset='satin_varnish')"), "no Satin Varnish in the menu of presets"
    window.wait_for("a varnish", lambda s: s["layers"] == ["Varnish"])
    for element, label, picture in (("Base", "Color", _boards), ("Varnish", "Roughness", _smudges)):
        path = window.folder / f"{picture.__name__.strip('_')}.png"
        _write_png(path, picture)
        link_image(window, f"{element} {label}", path)
    window.click(*window.find('images["smudges.png"].colorspace_settings', 0.8, VALUE))
    time.sleep(2.0)
    window.key("n")
    window.wait_for("numbers that are no color", lambda s: s["images"].get("Varnish Roughness") == ["smudges.png", "Non-Color"])
    window.picture("textured")

    pick(window, ADD, "layer_add_ready(ready='tinted_glaze')")
    state = window.wait_for("a glaze", lambda s: len(s["layers"]) == 2)
    state = move_down(window, state["layers"])
    assert state["layers"] == ["Varnish", "Tinted Glaze"], state
    x, y = window.find(state["paths"]["Tinted Glaze Tint"], MIDDLE, VALUE)
    window.click(x, y)
    time.sleep(2.0)
    window.click(_dot(window) + _HEX[0], y + _HEX[1])
    window.write(_STAIN)
    window.mouse("mousemove", x, state["panel"]["bottom"] - 10)
    before = state["tint"]
    state = window.wait_for("a stain's color", lambda s: s["tint"] != before)
    assert state["images"] == {"Base Color": ["boards.png", "sRGB"], "Varnish Roughness": ["smudges.png", "Non-Color"]}, state
    told(f"wooden table: {', '.join(state['layers'])}, tint {state['tint']}")
    window.picture("table")


def _dot(window: Window) -> int:
    panel = window.state()["panel"]
    return int(panel["left"] + DOT * (panel["right"] - panel["left"]))


def link_image(window: Window, value: str, path: Path) -> None:
    """The dot beside a value, Image Texture, Open, and the picture. Another texture that the mouse hit is undone."""
    _, y = window.find(window.state()["paths"][value], MIDDLE, VALUE)
    for row in (0, 1, -1, 2, -2):
        window.click(_dot(window), y)
        time.sleep(2.0)
        if value.endswith("Color"):
            window.key("i")  # underlined
        else:
            window.click(_dot(window) + _IMAGE_TEXTURE[0], y + _IMAGE_TEXTURE[1] + row * _MENU_ROW)
        state = window.wait_for("something linked", lambda s: value in s["linked"], patience=15.0)
        if state["linked"][value] == "ShaderNodeTexImage":
            break
        window.mouse("mousemove", _dot(window), state["panel"]["bottom"] - 10)
        window.key("ctrl+z")
        window.wait_for("nothing linked", lambda s: value not in s["linked"])
    else:
        raise AssertionError(f"no Image Texture in the menu of {value}")
    window.click(*window.find("image.open", 0.75))
    left, top, right, bottom = window.wait_for("the window that asks for a file", lambda s: s["browser"])["browser"]
    time.sleep(3.0)
    window.click(left + _FOLDER[0], top + _FOLDER[1])
    window.write(str(path))
    window.key("Return")
    time.sleep(1.5)
    window.click(right + _OPEN[0], bottom + _OPEN[1])
    window.wait_for(f"{path.name} in {value}", lambda s: s["images"].get(value, [""])[0] == path.name)
    told(f"texture: {path.name} as {value}")


def _boards(x: int, y: int) -> tuple[int, int, int]:
    light = 38 if y % 64 < 2 else 150 + 40 * (x * 7 + y * y) % 13
    return light, light * 3 // 4, light // 2


def _smudges(x: int, y: int) -> tuple[int, int, int]:
    return (60 + (x - 128) ** 2 // 200 + (y - 90) ** 2 // 300,) * 3


def _write_png(path: Path, color, size: int = 256) -> None:
    """A picture of a color at x and y, by Python alone."""
    rows = b"".join(b"\0" + bytes(min(max(c, 0), 255) for x in range(size) for c in color(x, y)) for y in range(size))
    parts = ((b"IHDR", struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)), (b"IDAT", zlib.compress(rows)), (b"IEND", b""))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(struct.pack(">I", len(d)) + k + d + struct.pack(">I", zlib.crc32(k + d)) for k, d in parts))
