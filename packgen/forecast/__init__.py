"""What a scene's bed will be like, told before the first sphere is placed."""

from packgen.forecast.forecast import forecast, remedies
from packgen.forecast.result import Forecast, SetForecast, ZoneForecast

__all__ = ["Forecast", "SetForecast", "ZoneForecast", "forecast", "remedies"]
