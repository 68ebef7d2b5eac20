"""The page itself, from a template."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jinja2


def page(content: Mapping[str, Any]) -> str:
    """The report as HTML, with style and curves inside; pictures and videos are files beside it.

    Args:
        content: What `templates/index.html.j2` shows.
    """
    folder = Path(__file__).parent / "templates"
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("index.html.j2").render(content)
