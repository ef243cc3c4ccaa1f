"""Hidden effects in forms that the grey box does not have: one module a family, each a table of ways to draw a form by the effect's name."""
