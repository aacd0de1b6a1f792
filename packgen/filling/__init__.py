"""From a scene and its container to a bed: what fits, an algorithm's run, what looks wrong after it."""
