"""Beds made of beds: parts cut out of one, and repeats of a periodic one."""
