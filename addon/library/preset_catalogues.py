# SPDX-License-Identifier: GPL-3.0-or-later
"""How the presets are sorted, in the menu and in the asset library."""

import uuid
from pathlib import Path

FOLDER = Path(__file__).parents[1] / "presets"
ASSETS = FOLDER / "lamina_presets.blend"
CATALOGUE_FILE = FOLDER / "blender_assets.cats.txt"

CATALOGUES = {
    "Paint": ("clear_coat_car_paint", "metallic_car_paint", "pearl_coating", "blue_wall_paint", "crayon_paint", "frosted_paint", "nail_polish"),
    "Lacquer and Varnish": ("piano_lacquer", "urushi_lacquer", "satin_varnish", "waxed_wood", "worn_varnish", "varnished_gold_leaf", "lacquered_brass"),
    "Glaze and Plastic": (
        "glazed_porcelain",
        "glazed_mug",
        "tinted_glaze",
        "milky_glaze",
        "celadon",
        "enamel_on_silver",
        "opal_enamel",
        "titanium_white_enamel",
        "pearl",
        "glossy_plastic",
    ),
    "Metal": ("polished_chrome", "brushed_nickel", "clean_copper", "metal_foil", "frosted_metal", "anodised_aluminium", "anodised_titanium"),
    "Weathered and Wet": (
        "patina_copper",
        "blued_steel",
        "oil_filmed_metal",
        "rusted_steel",
        "chipped_painted_steel",
        "rusted_painted_steel",
        "dusty_piano",
        "fingerprinted_chrome",
        "wet_asphalt",
    ),
}

# That of the presets which users save.
OWN = "Own Presets"

_NAMESPACE = uuid.UUID("6f5b1a38-2c6e-5d0e-9a3f-6c616d696e61")


def catalogue_id(catalogue: str) -> str:
    """The catalogue's UUID in the asset library; the same in every build, as users' files hold it."""
    return str(uuid.uuid5(_NAMESPACE, catalogue))


def catalogue_text() -> str:
    """What `blender_assets.cats.txt` of the asset library says."""
    paths = ["Lamina", *(f"Lamina/{name}" for name in CATALOGUES)]
    return catalogue_head("Asset catalogues of Lamina's presets") + "".join(f"{catalogue_line(path)}\n" for path in paths)


def catalogue_head(title: str) -> str:
    """What a file of catalogues begins with."""
    return f"# {title}\n\nVERSION 1\n\n"


def catalogue_line(path: str) -> str:
    """A catalogue in such a file, by its path."""
    return f"{catalogue_id(path.rpartition('/')[2])}:{path}:{path.replace('/', '-')}"


def thumbnail_of(preset: str) -> Path:
    """The picture of a preset."""
    return FOLDER / f"{preset}.png"
