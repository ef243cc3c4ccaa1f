"""Which run to take next, where the runs at hand leave more than one explanation."""
