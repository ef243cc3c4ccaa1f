"""Models as files that run without this package; a later issue."""
