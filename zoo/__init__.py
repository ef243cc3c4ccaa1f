"""fogzoo: compare, diagnose and compensate the thermal drift of fibre-optic gyroscopes."""

__version__ = "0.2.0"
