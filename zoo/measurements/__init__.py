"""Tables to tensors: reading, checking, averaging, splitting, writing."""
