# SPDX-License-Identifier: GPL-3.0-or-later
"""The bundle as a job type of Flamenco 3: a job compiler script. Needs no bpy."""

import json

from .bundle_names import ITEMS, SCRIPT

_SCRIPT = """\
// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of layered materials, written by `lamina farm`. Copy it into the folder `scripts` beside flamenco-manager.
const JOB_TYPE = {
  label: @LABEL@,
  description: "Render the pictures that `lamina farm` prepared; the workers' Blender needs no Lamina",
  settings: [
    { key: "files", type: "string", subtype: "dir_path", required: true,
      description: "The bundle's folder `files`, as the workers see it" },
    { key: "output", type: "string", subtype: "dir_path", required: true,
      description: "Where the pictures go, as the workers see it" },
    { key: "pictures", type: "int32", default: @COUNT@, visible: "submission" },
    { key: "pictures_per_task", type: "int32", default: @CHUNK@ },
  ],
};

function compileJob(job) {
  const settings = job.settings;
  const perTask = Math.max(1, settings.pictures_per_task);
  for (let first = 0; first < settings.pictures; first += perTask) {
    const last = Math.min(first + perTask, settings.pictures) - 1;
    const range = first + "-" + last;
    const task = author.Task("render-" + range, "blender");
    task.addCommand(author.Command("exec", {
      exe: "{blender}",
      args: [
        "-b", "--python-exit-code", "1", "--python", settings.files + "/@SCRIPT@", "--",
        "--items", settings.files + "/@ITEMS@", "--range", range, "--output", settings.output,
      ],
    }));
    job.addTask(task);
  }
}
"""


def job_type(name: str, count: int, chunk: int) -> str:
    """The text of a job compiler script for `count` pictures, `chunk` of them per task by default."""
    values = {"LABEL": json.dumps(f"Lamina: {name}"[:80]), "COUNT": str(count), "CHUNK": str(chunk), "SCRIPT": SCRIPT, "ITEMS": ITEMS}
    text = _SCRIPT
    for key, value in values.items():
        text = text.replace(f"@{key}@", value)
    return text
