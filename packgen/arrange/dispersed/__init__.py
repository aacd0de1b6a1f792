"""DISPERSED: spheres without gravity and without contacts, statistically a fluid of hard spheres."""
