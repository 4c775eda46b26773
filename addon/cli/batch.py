# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina batch`: every picture that a job file names, by several processes, resumable."""

import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path

from ...reference_py.atomic import output_folder
from ...reference_py.errors import LaminaError
from ...reference_py.lobes.cache import require_writable
from ..batch.items import Item, expand
from ..batch.job import KEYS, REQUIRED, Job
from ..material.backend import branches_here
from ..session import blender, say

FAILED = 1


def batch(options) -> int | None:
    """Render what is not there yet, then write the table and the contact sheets."""
    if options.worker:
        from ..batch.worker import serve

        serve(Path(options.output or "."), options.threads)
        return None
    if options.keys:
        print_keys()
        return None
    if not options.job:
        raise LaminaError("which job? Give a JOB.json (`lamina batch --keys` lists what it can say)")
    job = Job.load(options.job)
    items = expand(job)
    report = say("batch")
    with blender(report):
        from ..batch.lock import sole_owner
        from ..batch.outputs import missed, write_sheets, write_table
        from ..batch.run import run_items
        from ..blender.images import require_pictures

        require_pictures()
        branches_here(job.backend)
        require_writable(report)
        items = knowing_files(items, options.allow_missing, report)
        folder = output_folder(options.output or Path(options.job).with_suffix(""))
        with sole_owner(folder):
            outputs = run_items(items, folder, options.processes or _processes(), job.time_limit, report, options.replace)
            try:
                report(f"wrote {write_table(outputs, folder)}")
                for sheet in write_sheets(outputs, folder, job.name, report) if not options.no_sheet else ():
                    report(f"wrote {sheet}")
                written = True
            except LaminaError as error:  # such as a disk that is full by now
                report(str(error))
                written = False
    failed = [output for output in outputs if output.problem]
    report(f"{len(outputs) - len(failed)} of {len(outputs)} pictures are done")
    if sentence := missed(outputs):
        report(sentence)
    groups: dict[tuple, list[str]] = {}
    for output in failed:
        key = (output.item.scene.name if output.scene_failed else output.item.id, output.problem)
        groups.setdefault(key, []).append(output.item.id)
    for (name, problem), ids in groups.items():
        report(f"failed: {ids[0] if len(ids) == 1 else f'{len(ids)} pictures of scene {name}'}: {problem}")
    return FAILED if failed or not written else None


def knowing_files(items: Sequence[Item], allow_missing: bool, report: Callable[[str], None]) -> list[Item]:
    """The items with all in their hashes that their scenes read. Raises LaminaError for what is missing, unless that is allowed."""
    from ..batch.reads import reads_of, with_reads
    from ..blender.blend_files import refuse_missing

    reads = reads_of(items)
    for blend, read in reads.items():
        refuse_missing(Path(blend).name, read.missing, allow_missing, report)
    return with_reads(items, reads, report)


def print_keys() -> None:
    """Every key of a job file."""
    for key in KEYS:
        default = "needed" if key.default is REQUIRED else f"default {json.dumps(key.default)}"
        print(f"{key.name:11} {key.help}; {default}")


def _processes() -> int:
    """Cycles uses several cores well, so a process has four, as far as there are."""
    return max(1, (os.cpu_count() or 1) // 4)
