"""Laws of sphere sizes: how many spheres of which radius, how much mass; drawing spheres from them.

Example: ``Uniform(0.052, 0.075).sample(np.random.default_rng(0), 1000)`` gives 1000 radii [m].
"""

from packgen.distributions.base import UNIT_VOLUME, Distribution, ParameterError
from packgen.distributions.by_mass import RosinRammler, Sieve
from packgen.distributions.by_number import Constant, Lognormal, Normal, Uniform
from packgen.distributions.free import Free
from packgen.distributions.listed import Discrete, Listed

__all__ = [
    "UNIT_VOLUME", "Constant", "Discrete", "Distribution", "Free", "Listed", "Lognormal", "Normal",
    "ParameterError", "RosinRammler", "Sieve", "Uniform",
]  # fmt: skip
