"""Random scenes, made, broken, run end to end and judged; ``python -m tests.fuzz --help`` says how.

A number is a scene: the same number gives the same scene on every machine. Nothing here uses packgen but the
command itself, so that a fault of packgen cannot hide in the judge.
"""
