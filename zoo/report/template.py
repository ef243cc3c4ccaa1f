"""Pages from their templates, which lie beside this file."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from typing import Any

from markupsafe import Markup, escape


def filled(name: str, context: Mapping[str, Any]) -> str:
    """A template with everything put in; what is missing is an error, and text cannot become markup.

    Args:
        name: of the template's file.
        context: what it shows.
    """
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    folder = files("zoo.report")
    loader = FunctionLoader(lambda part: folder.joinpath(part).read_text(encoding="utf-8"))
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters["breakable"] = breakable
    page: str = environment.get_template(name).render(context)
    return page


def breakable(name: str) -> Markup:
    """A name that a narrow column breaks after an underscore rather than anywhere."""
    return Markup(str(escape(name)).replace("_", "_<wbr>"))
