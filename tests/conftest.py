# SPDX-License-Identifier: GPL-3.0-or-later
"""A clean Blender for each test that asks for it."""

import os
import signal
import sys
from pathlib import Path

import pytest

# Tests without Blender that took more than `QUICK` seconds when `make slow-tests` measured all; `make check` leaves them out.
SLOW = Path(__file__).with_name("slow.txt")
QUICK = 0.2
# What takes long and is tried in every run by other cases of its kind, or part by part: `make thorough` and `make matrix` run it.
THOROUGH = Path(__file__).with_name("thorough.txt")

# One thread for numpy's matrices, here and in all that tests start: they are small, and two halves of the suite whose threads wait
# for each other by spinning took a third more CPU and twice the time. Before numpy is read, which asks once.
os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

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


def _node_id(config, given: str) -> str:
    """That of a test that is named on the command line."""
    path, *names = given.split("::")
    return "::".join([Path(os.path.relpath(config.invocation_params.dir / path, config.rootpath)).as_posix(), *names])


def pytest_collection_modifyitems(config, items):
    slow = set(SLOW.read_text(encoding="utf-8").splitlines())
    for item in items:
        if item.nodeid in slow:
            item.add_marker(pytest.mark.slow)
    if not os.environ.get("LAMINA_THOROUGH"):
        thorough = set(THOROUGH.read_text(encoding="utf-8").splitlines()) - {_node_id(config, given) for given in config.args}
        config.hook.pytest_deselected(items=[item for item in items if item.nodeid in thorough])
        items[:] = [item for item in items if item.nodeid not in thorough]


# Seconds of every test of this run, its fixtures included.
_seconds: dict[str, float] = {}


def pytest_runtest_logreport(report):
    _seconds[report.nodeid] = _seconds.get(report.nodeid, 0.0) + report.duration


def pytest_sessionfinish(session, exitstatus):
    session.config.lamina_exit_status = int(exitstatus)
    if os.environ.get("LAMINA_MEASURE_TESTS"):
        known = set(SLOW.read_text(encoding="utf-8").splitlines())
        slow = {name for name, seconds in _seconds.items() if seconds > QUICK}
        SLOW.write_text("".join(f"{name}\n" for name in sorted(slow | (known - set(_seconds)))), encoding="utf-8")


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config):
    # Blender 4.5's wheel can hang for ever in its exit handlers, so leave without them.
    if "bpy" in sys.modules and hasattr(config, "lamina_exit_status"):
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(config.lamina_exit_status)
