"""COLLECTIVE_ARRANGEMENT: a zone is filled layer by layer, each arranged by projection."""
