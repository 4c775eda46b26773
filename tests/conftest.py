# SPDX-License-Identifier: GPL-3.0-or-later
"""A clean Blender for each test that asks for it."""

import os
import signal
import sys

import pytest

# A shell lets its background jobs, and so all that tests start, ignore Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session", autouse=True)
def bakes_of_this_session_alone(tmp_path_factory):
    """Nothing that was computed by other runs is used, and nothing is left in the user's cache."""
    os.environ["LAMINA_CACHE"] = str(tmp_path_factory.mktemp("bakes"))


@pytest.fixture(scope="session")
def registered_lamina():
    """Lamina, registered once in the bpy wheel."""
    pytest.importorskip("bpy")
    import lamina
    from lamina.addon.blender.environment import ensure_osl_query_on_path

    ensure_osl_query_on_path()
    lamina.register()
    yield lamina
    lamina.unregister()


@pytest.fixture
def blender(registered_lamina):
    """The module bpy, with factory settings and an empty scene."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    return bpy


def pytest_sessionfinish(session, exitstatus):
    session.config.lamina_exit_status = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config):
    # Blender 4.5's wheel can hang for ever in its exit handlers, so leave without them.
    if "bpy" in sys.modules and hasattr(config, "lamina_exit_status"):
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(config.lamina_exit_status)
