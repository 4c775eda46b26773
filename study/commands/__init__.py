# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands that exist in a checkout alone: `lamina chart` and `lamina figures`."""

# What `lamina chart` calls its charts, and the modules of `study.charts` that make them.
CHARTS = {
    "lobes": "lobe_errors", "presets": "preset_errors", "tiers": "tiers", "error": "error_by_angle", "grazing": "double_grazing", "stress": "stress_chart", "suite": "suite_chart",
    "pareto": "pareto_chart", "pair": "pair", "cost_factors": "cost_factors", "fit": "fit_charts", "scale": "scale", "viewport": "viewport_chart",
    "base_color": "base_color", "exchange": "exchange", "eevee": "eevee_energy", "scattering": "scattering", "pools": "pools", "peers": "peers",
    "live_values": "live_values", "followed": "followed", "mitsuba": "mitsuba", "published": "published", "sliders": "sliders", "tint_spectrum": "tint_spectrum", "spectral": "spectral", "closures": "closures",
}  # fmt: skip
# Names that charts had before, and still answer to.
OLD_NAMES = {"network": "lobes", "levers": "cost_factors"}


def add_commands(commands) -> None:
    """Add the arguments of the commands to argparse's subparsers."""
    chart = commands.add_parser("chart", help="measure a chart's numbers, print the table and draw it")
    chart.set_defaults(module=f"{__name__}.chart")
    chart.add_argument(
        "chart",
        type=lambda name: OLD_NAMES.get(name, name),
        choices=tuple(CHARTS),
        help=(
            "lobes (also network): what Cycles is told against the exact model; presets: what Cycles renders of every preset against the truth; "
            "tiers: the same in every tier, for the presets of the paper and a suite of stacks; "
            "error: every model against the truth, by angle; "
            "stress: every model in every hard case; suite: the two truths against each other; "
            "pareto: error against cost of every way to render a surface in Cycles; "
            "cost_factors (also levers): what lobes and closures cost in Cycles; "
            "scale: time and memory over the number of materials, layers, samples and pictures; "
            "fit: how well stacks are found from measurements, and a blue paint by other models; "
            "viewport: how EEVEE shows every preset, and eevee: how bright; LAMINA_BLENDER names a Blender that has it; "
            "grazing: the two truths where view and light graze; "
            "scattering: the two truths on stacks whose media scatter, and half spaces against known answers; "
            "peers: other people's models of media that scatter, error and cost; "
            "base_color and live_values: bakes that follow the base's color, and other values, at nine of each; "
            "followed: which textured values keep a bake, and how far off is what stands in for films and anisotropy; "
            "tint_spectrum: glazes in RGB and as spectra against the truth; "
            "pools: what the albedo of many masks loses where patches share closures; "
            "sliders: the manual's strips, five renders for each parameter; "
            "published: what others published of layered surfaces, beside the truth; "
            "mitsuba: a sphere by Cycles and by Mitsuba with the exported table; "
            "exchange: what becomes of the MaterialX files in the folders of --files; "
            "pair: one car paint by Cycles' layer(), by Lamina and as explicit geometry"
        ),
    )
    chart.add_argument("-o", "--output", default=".", metavar="FOLDER", help="folder for table and picture (default: %(default)s)")
    chart.add_argument(
        "--surface", nargs="+", metavar="NAME", help="pareto, viewport, eevee: presets or stacks of the suite (default: six surface types; all presets)"
    )
    chart.add_argument("--files", nargs="+", metavar="FOLDER", help="exchange: folders with MaterialX files, such as those of MaterialX and OpenPBR")
    chart.add_argument("--rounds", type=int, metavar="N", help="pareto: rounds of timing (default: 5)")

    figures = commands.add_parser("figures", help="compute the paper's figures and check its sentences about them")
    figures.set_defaults(module=f"{__name__}.figures")
    figures.add_argument("-o", "--out", dest="output", default="figures", metavar="FOLDER", help="folder for tables and pictures (default: %(default)s)")
    figures.add_argument("--only", nargs="+", metavar="FIGURE", help="some of figure3, figure5 ... figure9, spectral (default: all)")
    figures.add_argument("--size", type=int, default=112, metavar="PIXELS", help="width of a sphere (default: %(default)s)")
