# SPDX-License-Identifier: GPL-3.0-or-later
"""The bundle as an Open Job Description template (2023-09, with task chunking), as AWS Deadline Cloud runs it. Needs no bpy."""

from .bundle_names import FILES, ITEMS, SCRIPT


def template(name: str, count: int, chunk: int) -> dict:
    """A job template of `count` pictures, `chunk` of them per task by default."""
    return {
        "specificationVersion": "jobtemplate-2023-09",
        "extensions": ["TASK_CHUNKING"],
        "name": "".join(c for c in name if c.isprintable())[:64] or "Lamina",
        "description": "Pictures of layered materials, written by `lamina farm`. `lamina batch` with the same job and output folder "
                       "verifies them and makes the table and the contact sheets.",
        "parameterDefinitions": [
            {"name": "Files", "type": "PATH", "objectType": "DIRECTORY", "dataFlow": "IN", "default": FILES,
             "description": "Scenes, materials, script and list of the pictures"},
            {"name": "Output", "type": "PATH", "objectType": "DIRECTORY", "dataFlow": "OUT", "default": "output",
             "description": "Where the pictures go"},
            {"name": "Blender", "type": "STRING", "default": "blender", "description": "How a worker starts Blender; it needs no Lamina"},
            {"name": "Pictures", "type": "STRING", "default": f"0-{count - 1}" if count > 1 else "0",
             "description": "Which ones, by their place in items.json"},
            {"name": "PicturesPerTask", "type": "INT", "default": chunk, "minValue": 1},
        ],
        "steps": [{
            "name": "Render",
            "parameterSpace": {"taskParameterDefinitions": [{
                "name": "Pictures", "type": "CHUNK[INT]", "range": "{{Param.Pictures}}",
                "chunks": {"defaultTaskCount": "{{Param.PicturesPerTask}}", "rangeConstraint": "CONTIGUOUS"},
            }]},
            "script": {"actions": {"onRun": {
                "command": "{{Param.Blender}}",
                "args": ["-b", "--python-exit-code", "1", "--python", "{{Param.Files}}/" + SCRIPT, "--",
                         "--items", "{{Param.Files}}/" + ITEMS, "--range", "{{Task.Param.Pictures}}", "--output", "{{Param.Output}}"],
                "cancelation": {"mode": "TERMINATE"},
            }}},
        }],
    }  # fmt: skip
