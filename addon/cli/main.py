# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments, exit codes and messages of every command. Imports neither bpy nor numpy until a command needs them.

Exit codes: 0 done, 1 something failed, 2 bad input or a missing means such as OSL, 130 cancelled by Ctrl-C, 143 by SIGTERM.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.util import find_spec

from ...reference_py.errors import LaminaError
from ...reference_py.version import version
from ..blender.interrupt import Terminated, raising
from ..material.backend import BACKENDS, DEFAULT_BACKEND

DONE, FAILED, BAD_INPUT, CANCELLED, TERMINATED = 0, 1, 2, 130, 143
STACK_HELP = "name of a preset (see `lamina presets`) or a JSON file"


def _between(low: int, high: int):
    """An argparse type: a whole number within bounds."""

    def convert(text: str) -> int:
        try:
            number = int(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number; choose {low} to {high}") from None
        if not low <= number <= high:
            raise argparse.ArgumentTypeError(f"{text[:24]} is out of range; choose {low} to {high}")
        return number

    return convert


def _layers(text: str) -> int | str:
    """An argparse type: "auto" or a count."""
    return text if text == "auto" else _between(0, 8)(text)


_samples = _between(1, 1_000_000)
_pixels = _between(2, 16_384)


class _Parser(argparse.ArgumentParser):
    """argparse with one line per mistake."""

    def error(self, message: str):
        raise LaminaError(f"{message} (see `{self.prog} --help`)")


class _Version(argparse.Action):
    """argparse's own would read the manifest for every command."""

    def __call__(self, parser, *_) -> None:
        print(f"lamina {version()}")
        parser.exit()


def build_parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="lamina", description="Layered materials for Blender's Cycles, with the error stated.")
    parser.add_argument("--version", action=_Version, nargs=0, default=argparse.SUPPRESS, help="show program's version number and exit")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)

    presets = _command(commands, "presets", "print_values", "list the presets")
    schema = _command(commands, "schema", "print_values", "list every key of a stack file, with its range and default")
    models = _command(commands, "models", "print_values", "list the models that `albedo` and `eval` know")
    albedo = _command(commands, "albedo", "print_values", "share of light that a stack reflects, by view angle")
    albedo.add_argument("stack", metavar="STACK", help=STACK_HELP)
    albedo.add_argument("--theta", type=float, nargs="+", default=[0.0, 30.0, 60.0], metavar="DEG", help="view angles in degrees (default: 0 30 60)")
    evaluate = _command(commands, "eval", "print_values", "BRDF value in 1/sr, without the cosine")
    evaluate.add_argument("stack", metavar="STACK", help=STACK_HELP)
    evaluate.add_argument("--wo", required=True, metavar="THETA,PHI", help="direction to the viewer, degrees")
    lights = evaluate.add_mutually_exclusive_group(required=True)
    lights.add_argument("--wi", nargs="+", metavar="THETA,PHI", help="directions to the light, degrees")
    lights.add_argument("--grid", type=_between(1, 45), metavar="DEG", help="all directions to the light on a grid of this many degrees")
    evaluate.add_argument("--csv", action="store_true", help="print a table: angles in degrees, f, and its standard error where the model has one")
    plot = _command(commands, "plot", "plot", "draw a stack: its layers, albedo by angle, f in the plane of incidence, and lobes")
    plot.add_argument("stack", metavar="STACK", help=STACK_HELP)
    plot.add_argument("-o", "--output", required=True, metavar="FILE.svg", help="picture to write")
    plot.add_argument("--theta", type=float, nargs="+", default=[0.0, 30.0, 60.0], metavar="DEG", help="view angles of the lobes (default: 0 30 60)")
    for command in (albedo, evaluate, plot):
        command.add_argument("--model", default="adding", help="see `lamina models` (default: %(default)s, the truth)")
        command.add_argument("--option", action="append", default=[], metavar="NAME=VALUE", help="an option of the model; repeatable")

    render = _command(commands, "render", "render", "render a stack with Cycles")
    render.add_argument("stack", metavar="STACK", help=STACK_HELP)
    render.add_argument(
        "--scene",
        choices=("sphere", "ball", "furnace"),
        default="ball",
        help="a sphere in the sun, a ball in a studio, or a plane under a white world (default: %(default)s)",
    )
    render.add_argument("-o", "--output", metavar="FILE", help="picture to write: .exr (linear) or .png")
    render.add_argument("--theta", type=float, nargs="+", metavar="DEG", help="view angles of the furnace, degrees (default: 0 30 60)")
    render.add_argument("--samples", type=_samples, default=64, metavar="N", help="samples per pixel (default: %(default)s)")
    render.add_argument("--size", type=_pixels, metavar="PIXELS", help="width and height (default: 256; the furnace 32)")
    apply = _command(commands, "apply", "render", "give an object of a .blend file a stack as its material")
    apply.add_argument("--stack", required=True, metavar="STACK", help=STACK_HELP)
    apply.add_argument("--object", required=True, metavar="NAME", help="object that gets the material")
    apply.add_argument("--slot", metavar="NAME|NUMBER|all", help="material slots: a material's name, a number from 0, or all (default: the active one)")
    alone = apply.add_mutually_exclusive_group()
    alone.add_argument("--single-user", action="store_true", help="give the object a mesh of its own, so that no other object shows the material")
    alone.add_argument("--object-level", action="store_true", help="put the material on the object and not on its mesh, which others may share")
    apply.add_argument("input", metavar="IN.blend")
    apply.add_argument("-o", "--output", required=True, metavar="OUT.blend")
    explain = _command(commands, "explain", "explain", "say which tier the tier auto chooses for a stack, at which error and cost, and why")
    explain.add_argument("stack", metavar="STACK", help=STACK_HELP)
    explain.add_argument(
        "--tolerance", type=float, default=None, metavar="PERCENT", help="largest error that may be seen, in percent of the reflected light (default: 2)"
    )
    explain.add_argument("--blend", metavar="FILE", help="judge by what the scene's camera sees of an object, at the render's size")
    explain.add_argument("--object", metavar="NAME", help="the object in that file")
    shader = _command(commands, "shader", "print_values", "print the OSL shader that is generated for a stack")
    shader.add_argument("stack", metavar="STACK", help=STACK_HELP)
    for command in (render, apply, shader):
        command.add_argument("--quality", "--tier", dest="tier", default=None, help="how the stack is told to Cycles (default: the extension's)")
    for command in (render, apply):
        command.add_argument(
            "--backend", choices=BACKENDS, default=DEFAULT_BACKEND, help="stock nodes, an OSL shader, or both (default: %(default)s, both where there is OSL)"
        )
    convert = _command(commands, "convert", "convert", "convert a stack or an object's material to Principled or MaterialX, or a MaterialX file to a stack")
    convert.add_argument("source", metavar="STACK|FILE.mtlx|IN.blend", help=STACK_HELP + ", a MaterialX file, or a Blender file")
    convert.add_argument("--object", metavar="NAME", help="the object of IN.blend whose material is converted")
    convert.add_argument("--material", metavar="NAME", help="which material of a MaterialX file (default: the first)")
    convert.add_argument("--to", choices=("principled", "openpbr", "standard_surface", "gltf_pbr", "layers"), help="what a stack becomes")
    convert.add_argument("-o", "--output", metavar="FILE", help="file to write: .json for Principled and stacks, .mtlx for the others")
    export = _command(commands, "export", "export", "write a stack for other renderers: a table of the truth, read back and its error stated")
    export.add_argument("stack", metavar="STACK", help=STACK_HELP)
    export.add_argument(
        "--to", required=True, choices=("merl", "rgl", "csv", "mitsuba", "pbrt"),
        help="MERL's table (.binary), RGL's (.bsdf), angles as text (.csv), a scene of Mitsuba 3 (.xml) or a material of pbrt-v4 (.pbrt)",
    )  # fmt: skip
    export.add_argument(
        "--as",
        dest="form",
        choices=("measured", "layers"),
        help="mitsuba, pbrt: by RGL's table beside FILE (default), or as explicit layers with single facets",
    )
    export.add_argument("--step", type=_between(1, 45), metavar="DEG", help="csv: degrees between the angles (default: 5; anisotropic 10)")
    export.add_argument("-o", "--output", required=True, metavar="FILE", help="file to write")
    export.add_argument(
        "--walks", type=_between(16, 1_000_000), default=256, metavar="N", help="walks per value, where the truth is walks (default: %(default)s)"
    )
    for command in (albedo, evaluate, plot, export):
        command.add_argument("--surface", choices=("single", "multiple"), help="surfaces of the truths: one scattering event or lossless")
    principled = _command(commands, "principled", "principled", "write a .blend file whose Lamina materials are Principled ones, and say each one's error")
    principled.add_argument("input", metavar="IN.blend", nargs="?")
    principled.add_argument("-o", "--output", metavar="OUT.blend")
    principled.add_argument("--presets", action="store_true", help="list the error of every preset instead")
    fit = _command(commands, "fit", "fit", "fit a layer stack to measured reflectance")
    fit.add_argument(
        "file", metavar="FILE", help="MERL .binary, RGL or Zemax .bsdf, Speos .brdf, ASTM .astm, ALTA .dat, or a table .csv; with --sample a stack"
    )
    fit.add_argument("-o", "--output", metavar="STACK.json", help="stack file to write")
    fit.add_argument("--layers", type=_layers, default="auto", metavar="auto|N", help="count of layers (default: the fewest that the data support)")
    fit.add_argument("--base", default="auto", metavar="KIND", help="auto, lambert, oren_nayar or conductor (default: %(default)s)")
    fit.add_argument("--cloudy", action="store_true", help="try a medium that scatters above the base too, which takes minutes")
    fit.add_argument("--wavelength", type=float, metavar="NM", help="fit one wavelength alone, as a grey stack")
    fit.add_argument("--steepest", type=_between(10, 89), metavar="DEG", help="largest angle from the normal that is used (default: 85)")
    fit.add_argument("--model", default="adding", help="model that is fitted (default: %(default)s, the truth that auto renders)")
    fit.add_argument("--sample", metavar="MODEL", help="FILE is a stack or a preset: fit samples of this model of it")
    fit.add_argument("--samples", type=_between(50, 20_000), default=500, metavar="N", help="pairs of directions that are fitted (default: %(default)s)")
    fit.add_argument("--seed", type=_between(0, 2**31), default=0, metavar="N", help="of the pairs and the starts (default: %(default)s)")
    fit.add_argument("--report", metavar="PICTURE", help="slices, lobes and residuals, .png (needs matplotlib)")
    fit.add_argument("--theta", type=float, nargs="+", metavar="DEG", help="incidence angles of the report (default: those of the paper's figure 9)")
    fit.add_argument("--compare", action="store_true", help="fit other models too and print their errors")
    demo = _command(commands, "demo", "demo", "render a contact sheet of the paper's presets, or of all, and print their errors")
    demo.add_argument("--all", action="store_true", help="all presets, which takes a quarter of an hour (default: those of the paper)")
    demo.add_argument("-o", "--output", default="demo", metavar="FOLDER", help="folder for the pictures (default: %(default)s)")
    demo.add_argument("--samples", type=_samples, default=48, metavar="N", help="samples per pixel (default: %(default)s)")
    demo.add_argument("--size", type=_pixels, default=288, metavar="PIXELS", help="width of a tile (default: %(default)s)")
    batch = _command(commands, "batch", "batch", "render every picture that a job file names, by several processes; run it again to go on where it stopped")
    batch.epilog = 'A job is a JSON file such as {"stacks": ["clean_copper"], "views": [0, 120, 240], "size": 128}; `--keys` lists all it can say.'
    batch.add_argument("job", metavar="JOB.json", nargs="?", help="what to render")
    batch.add_argument("-o", "--output", metavar="FOLDER", help="folder for pictures, table and contact sheets (default: named like the job)")
    batch.add_argument("--processes", type=_between(1, 256), metavar="N", help="Blenders at work at the same time (default: one for each four cores)")
    batch.add_argument(
        "--replace", action="store_true", help="render anew what is there of other inputs, such as of this job before it was changed (default: refuse)"
    )
    batch.add_argument("--no-sheet", action="store_true", help="write no contact sheets")
    batch.add_argument("--keys", action="store_true", help="list every key of a job file, and leave")
    batch.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    batch.add_argument("--threads", type=_between(1, 1024), default=1, help=argparse.SUPPRESS)
    farm = _command(commands, "farm", "farm", "write a job as files that a render farm runs without Lamina: Open Job Description and Flamenco")
    farm.add_argument("job", metavar="JOB.json", help="what to render (see `lamina batch --keys`)")
    farm.add_argument("-o", "--output", metavar="FOLDER", required=True, help="new folder for the template, its scenes and scripts")
    farm.add_argument("--chunk", type=_between(1, 10_000), default=10, metavar="N", help="pictures per task (default: %(default)s)")
    info = _command(commands, "info", "info", "print what a picture's header says of its origin, and whether its pixels are those that were written")
    info.add_argument("picture", metavar="PICTURE.exr")
    cache = _command(commands, "cache", "cache", "show what bakes take on the disk, and clean it")
    cache.add_argument("--clean", action="store_true", help="remove what is kept")
    cache.add_argument("--older-than", type=_between(0, 100_000), metavar="DAYS", help="with --clean: only what was not used for so many days")
    for command in (apply, batch, farm):
        command.add_argument(
            "--allow-missing", action="store_true", help="go on without files that the scene asks for and that are not there (default: refuse)"
        )
    for command in (presets, schema, models, albedo, evaluate, render, explain, fit, info, cache):
        command.add_argument("--json", action="store_true", help="print JSON")
    if study := _study():
        study.add_commands(commands)
    return parser


def _study():
    """The commands that a checkout has besides; None in an installed Lamina."""
    root = __package__.rsplit(".", 2)[0]
    return import_module(f"{root}.study.commands") if find_spec(f"{root}.study") else None


def _command(commands, name: str, module: str, summary: str) -> argparse.ArgumentParser:
    command = commands.add_parser(name, help=summary, description=summary[0].upper() + summary[1:] + ".")
    command.set_defaults(module=f"{__package__}.{module}")
    return command


def _keep_bakes() -> None:
    from ...reference_py.lobes.cache import keep_in
    from ..blender.user_folders import cache_folder

    keep_in(cache_folder(), lambda message: print(f"lamina: {message}", file=sys.stderr))


def run(arguments: Sequence[str]) -> int:
    """Run one command; returns its exit code. Bad input is one line on stderr."""
    try:
        options = build_parser().parse_args(arguments)
        handler = getattr(import_module(options.module), options.command)
        _keep_bakes()
        with raising():
            code = handler(options) or DONE
        sys.stdout.flush()
        return code
    except BrokenPipeError:  # whoever read the output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except OSError as error:
        print(f"lamina: cannot write the output: {error.strerror or error}", file=sys.stderr)
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except LaminaError as error:
        print(f"lamina: {' '.join(str(error).split())}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt as signal:
        print("lamina: cancelled", file=sys.stderr)
        return TERMINATED if isinstance(signal, Terminated) else CANCELLED
    except SystemExit as done:  # argparse leaves so after --help
        return int(done.code or DONE)


def main() -> None:
    """Entry point of the console script."""
    # numpy is not imported yet; the matrices of bakes and fits are small, and threads that wait for each other cost half as much again
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    code = run(sys.argv[1:])
    sys.stdout.flush()
    sys.stderr.flush()
    if "bpy" in sys.modules:
        # The bpy wheel's exit handlers now and then wait for each other for ever; all files are closed by now.
        os._exit(code)
    sys.exit(code)
