# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina farm`: a job as a folder that render farms run without Lamina."""

import json
from pathlib import Path

from ...reference_py.atomic import output_folder, write_text
from ...reference_py.errors import LaminaError
from ..batch.items import expand
from ..batch.job import Job
from ..farm.bundle_names import FILES
from ..farm.flamenco import job_type
from ..farm.openjd import template
from ..nodes.backend import backend_here
from .session import blender, say


def farm(options) -> None:
    """Write files/, template.json and lamina_flamenco.js into a new folder."""
    job = Job.load(options.job)
    items = expand(job)
    folder = Path(options.output)
    if folder.is_dir() and any(folder.iterdir()):
        raise LaminaError(f"{folder}: this folder is not empty; choose a new one")
    output_folder(folder)
    report = say("farm")
    with blender(report):
        from ..farm.bundle import write_files

        backend_here(job.backend)
        write_files(items, job.time_limit, folder / FILES, report)
    write_text(folder / "lamina_flamenco.js", job_type(job.name, len(items), options.chunk))
    write_text(folder / "template.json", json.dumps(template(job.name, len(items), options.chunk), indent=2) + "\n")
    report(f"wrote {len(items)} pictures to render into {folder}")
    report(f"here: openjd run {folder}/template.json --step Render -p Output=FOLDER; then lamina batch {options.job} -o FOLDER verifies them")
