"""The space between spheres, for particle-resolved CFD: contacts, their treatment, walls, surfaces."""
