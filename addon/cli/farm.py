# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina farm`: a job as a folder that render farms run without Lamina."""

import json
import os
import shlex
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ...reference_py.atomic import output_folder, write_text
from ...reference_py.errors import LaminaError
from ...reference_py.lobes.cache import require_writable
from ..batch.items import expand
from ..batch.job import Job
from ..farm.bundle_names import FILES
from ..farm.flamenco import job_type
from ..farm.openjd import template
from ..material.backend import branches_here
from ..session import blender, say
from .batch import knowing_files


def farm(options) -> None:
    """Write files/, template.json and lamina_flamenco.js into a new folder."""
    job = Job.load(options.job)
    items = expand(job)
    folder = Path(options.output)
    report = say("farm")
    with _whole_folder(folder) as made, blender(report):
        from ..farm.bundle import write_files

        branches_here(job.backend)
        require_writable(report)
        items = knowing_files(items, options.allow_missing, report)
        write_files(items, job.time_limit, options.allow_missing, made / FILES, report)
        write_text(made / "lamina_flamenco.js", job_type(job.name, len(items), options.chunk))
        write_text(made / "template.json", json.dumps(template(job.name, len(items), options.chunk), indent=2) + "\n")
    report(f"wrote {len(items)} pictures to render into {folder}")
    template_file, job_file = shlex.quote(str(folder.resolve() / "template.json")), shlex.quote(str(Path(options.job).resolve()))
    report(
        f"here: openjd run {template_file} --step Render -p Blender=blender -p Output=/abs/FOLDER; then lamina batch {job_file} -o /abs/FOLDER verifies them"
    )


@contextmanager
def _whole_folder(folder: Path) -> Iterator[Path]:
    """Yields a temporary folder beside `folder`, which takes its place in the end. Raises LaminaError when that is not empty.

    Beside and not in it, so that what a .blend links to by a relative path stays where the file says.
    """
    try:
        if folder.is_dir() and any(folder.iterdir()):
            raise LaminaError(f"{folder}: this folder is not empty; choose a new one")
    except OSError as error:
        raise LaminaError(f"{folder}: cannot read this folder: {error.strerror}") from None
    parent = output_folder(folder.absolute().parent)
    made = Path(tempfile.mkdtemp(prefix=".lamina-farm-", dir=parent))
    try:
        umask = os.umask(0)
        os.umask(umask)
        made.chmod(0o777 & ~umask)  # mkdtemp makes folders private
        yield made
        if folder.is_dir():
            folder.rmdir()  # Windows renames to no folder that is there
        made.rename(folder)
    except OSError as error:
        raise LaminaError(f"{folder}: cannot make this folder: {error.strerror or error}") from None
    finally:
        shutil.rmtree(made, ignore_errors=True)
