"""Many runs of one scene with other values: which runs, which of them are done, and the table of all."""
