# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets that are saved from a window: the picture is rendered beside it, in a process, and the preset is there once that is done."""

import shutil
import tempfile
import time
from pathlib import Path

import bpy

from ...reference_py.errors import LaminaError, Sentence
from ...reference_py.material import presets
from ...reference_py.material.stack import Stack
from ..blender.translation import rpt_
from ..blender.user_folders import presets_folder
from ..library import asset_library, preset_assets, preset_process, user_presets
from .process import Process

TICK = 0.2
# Seconds that a window's status bar says what became of it.
_SAID_FOR = 8.0


class Saving(Process):
    """One preset in the making. Until it is done all of it lies in a temporary folder."""

    def __init__(self, material: bpy.types.Material, label: str, stack: Stack, catalogue: str):
        user_presets.free_name(label)
        preset_assets.require_savable(material)
        self.label, self.stack = label, stack
        self._folder = tempfile.TemporaryDirectory(prefix="lamina.")
        self.folder = Path(self._folder.name)
        try:
            preset_assets.write_asset(self.folder / preset_process.ASSET, material, stack, catalogue, None)
            super().__init__(Sentence("the picture of a preset"), preset_process.command(self.folder))
        except BaseException:
            self.clear()
            raise

    def keep(self) -> list[str]:
        """Put what was made into the folder of own presets; what to tell the user. Raises LaminaError; then nothing of it is there."""
        name, why = user_presets.save(self.label, self.stack, self._draw, lambda path: _copy(self.folder / preset_process.ASSET, path))
        asset_library.show_own()
        told = [rpt_("preset {name} saved in {folder}").format(name=presets.label(name), folder=presets_folder())]
        return told + ([rpt_("the preset has no picture: {reason}").format(reason=why)] if why else [])

    def _draw(self, path: Path) -> None:
        if self.result is None:
            raise LaminaError(self.error)
        _copy(self.folder / preset_process.PICTURE, path)

    def clear(self) -> None:
        """Remove the temporary folder."""
        self._folder.cleanup()


def _copy(source: Path, target: Path) -> None:
    try:
        shutil.copyfile(source, target)
    except OSError as error:
        raise LaminaError("{target}: cannot write it: {reason}", target=target, reason=error.strerror or error) from None


_running: Saving | None = None
_said: tuple[str, float] = ("", 0.0)


def running() -> Saving | None:
    """The preset that is being saved."""
    return _running


def start(material: bpy.types.Material, label: str, stack: Stack, catalogue: str) -> None:
    """Begin to save a material's stack as a preset. Raises LaminaError when one is being saved already, or for what cannot be saved."""
    global _running
    if _running is not None:
        raise LaminaError("preset {name} is being saved; wait for it, or cancel it", name=_running.label)
    _running = Saving(material, label, stack, catalogue)
    bpy.app.timers.register(tick, first_interval=TICK, persistent=True)


def cancel() -> None:
    """Stop saving; no file of the preset is left."""
    global _running
    if _running is not None:
        _running.cancel()
        _running.clear()
        _running = None


def tick() -> float | None:
    """Look after the preset that is being saved, then say for a while what became of it. Returns the seconds to the next look."""
    global _running, _said
    _redraw()
    if _running is not None:
        if not _running.is_done:
            return TICK
        saving, _running = _running, None
        try:
            sentences = saving.keep()
        except LaminaError as error:
            sentences = [rpt_("the preset is not saved: {reason}").format(reason=error.told(rpt_))]
        saving.clear()
        for sentence in sentences:
            print(f"Lamina: {sentence}")
        _said = f"Lamina: {'; '.join(sentences)}", time.monotonic()
        _show(_said[0])
    if _said[0] and time.monotonic() - _said[1] < _SAID_FOR:
        return TICK
    _said = "", 0.0
    _show(None)
    return None


def stop() -> None:
    """End the timer and what is being saved."""
    if bpy.app.timers.is_registered(tick):
        bpy.app.timers.unregister(tick)
    cancel()


def _show(text: str | None) -> None:
    for window in bpy.context.window_manager.windows:
        window.workspace.status_text_set(text)


def _redraw() -> None:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()
