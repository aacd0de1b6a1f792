"""Mathematical programmes over the contacts of a bed: plain arrays in and out, no bed, scene or report."""
