# SPDX-License-Identifier: GPL-3.0-or-later
"""What MkDocs does beyond its own: files that the manual shows from figures/ come along, and links to other files of the repository, which
are no pages, become their names alone.
"""

import re
from pathlib import Path

from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parent.parent
_LINK = re.compile(r"(?P<picture>!?)\[(?P<text>[^\]]*)\]\(\.\./(?P<path>[^)#\s]+)(?P<anchor>#[^)]*)?\)")


def on_files(files, config):
    """Add the pictures of figures/ that a page shows, at figures/ of the site. Raises FileNotFoundError for one that is not there."""
    shown = {match["path"] for page in files.documentation_pages() for match in _LINK.finditer(page.content_string) if match["picture"]}
    for path in sorted(shown):
        if not (ROOT / path).is_file():
            raise FileNotFoundError(f"a page shows {path}, which is not there")
        files.append(File(path, str(ROOT), config.site_dir, config.use_directory_urls))
    return files


def on_page_markdown(markdown, page, config, files):
    """Pictures by their place in the site; of other links out of docs/ the text."""
    return _LINK.sub(lambda m: f"![{m['text']}]({m['path']})" if m["picture"] else m["text"], markdown)


def on_post_build(config):
    """No address is known, so there is no map of the site."""
    for name in ("sitemap.xml", "sitemap.xml.gz"):
        Path(config.site_dir, name).unlink(missing_ok=True)
