"""Mathematical programmes over the contacts of spheres: plain arrays in and out, no bed, scene or report."""
