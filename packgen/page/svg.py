"""Small plots as SVG text: drawn here, so that a page needs neither a library nor JavaScript."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

WIDTH, HEIGHT = 460.0, 300.0
LEFT, RIGHT, TOP, BOTTOM = 64.0, 16.0, 12.0, 46.0
LETTER = 6.8  # width of a letter of a label, on average
DASHES = {"line": "", "dashed": ' stroke-dasharray="7 4"', "dotted": ' stroke-dasharray="2 3"'}


@dataclass(frozen=True, slots=True)
class Series:
    """Points of a curve.

    Attributes:
        label: Name in the legend; empty for none.
        x: Abscissas.
        y: Ordinates, as many.
        style: ``line``, ``dashed``, ``dotted``, or ``dots`` without a line.
        colour: Number of the page's colour, from 0.
    """

    label: str
    x: Sequence[float]
    y: Sequence[float]
    style: str = "line"
    colour: int = 0


def curves(title: str, x_label: str, y_label: str, series: Sequence[Series]) -> str:
    """Return a plot of curves on linear axes.

    Args:
        title: What a screen reader says of it.
        x_label: Label of the abscissa.
        y_label: Label of the ordinate.
        series: The curves; at least one with a point.
    """
    legend = [each for each in series if each.label]
    top = TOP + 18.0 * math.ceil(len(legend) / 2)
    x_low, x_high, x_ticks = ticks([x for each in series for x in each.x])
    y_low, y_high, y_ticks = ticks([y for each in series for y in each.y])

    def across(x: float) -> float:
        return LEFT + (x - x_low) / (x_high - x_low) * (WIDTH - LEFT - RIGHT)

    def down(y: float) -> float:
        return HEIGHT - BOTTOM - (y - y_low) / (y_high - y_low) * (HEIGHT - top - BOTTOM)

    parts = []
    for tick in x_ticks:
        parts.append(_line(across(tick), top, across(tick), HEIGHT - BOTTOM, "grid"))
        parts.append(_text(across(tick), HEIGHT - BOTTOM + 16, _number(tick), "middle"))
    for tick in y_ticks:
        parts.append(_line(LEFT, down(tick), WIDTH - RIGHT, down(tick), "grid"))
        parts.append(_text(LEFT - 6, down(tick) + 4, _number(tick), "end"))
    for each in series:
        points = [(across(x), down(y)) for x, y in zip(each.x, each.y, strict=True)]
        colour = f"c{each.colour % 6}"
        if each.style == "dots":
            parts += [f'<circle class="{colour}" cx="{x:.1f}" cy="{y:.1f}" r="4"/>' for x, y in points]
        else:
            path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
            parts.append(f'<polyline class="{colour}" points="{path}"{DASHES[each.style]}/>')
    parts += _legend(legend)
    return _svg(title, parts, x_label, y_label, top=top)


def bars(title: str, x_label: str, y_label: str, names: Sequence[str], values: Sequence[float]) -> str:
    """Return a plot of upright bars, each with its name below."""
    _, high, marks = ticks([0.0, *values])
    step = (WIDTH - LEFT - RIGHT) / max(len(names), 1)
    every = math.ceil(len(names) / 16)
    parts = []
    for tick in marks:
        level = HEIGHT - BOTTOM - tick / high * (HEIGHT - TOP - BOTTOM)
        parts.append(_line(LEFT, level, WIDTH - RIGHT, level, "grid"))
        parts.append(_text(LEFT - 6, level + 4, _number(tick), "end"))
    for place, (name, value) in enumerate(zip(names, values, strict=True)):
        tall = value / high * (HEIGHT - TOP - BOTTOM)
        left = LEFT + (place + 0.1) * step
        parts.append(
            f'<rect class="c0" x="{left:.1f}" y="{HEIGHT - BOTTOM - tall:.1f}" width="{0.8 * step:.1f}" '
            f'height="{tall:.1f}"><title>{escape(name)}: {value:.4g}</title></rect>'
        )
        if place % every == 0:
            parts.append(_text(left + 0.4 * step, HEIGHT - BOTTOM + 16, name, "middle"))
    return _svg(title, parts, x_label, y_label)


def lying_bars(title: str, names: Sequence[str], values: Sequence[float], unit: str) -> str:
    """Return a plot of bars that lie, each with its name before and its value after it."""
    high = max([*values, 1e-12])
    left = max(60.0, LETTER * max(map(len, names), default=0)) + 6.0
    row = min((HEIGHT - 20.0) / max(len(names), 1), 28.0)
    parts = []
    for place, (name, value) in enumerate(zip(names, values, strict=True)):
        top = 10.0 + place * row
        long = value / high * (WIDTH - left - 76.0)
        parts.append(_text(left - 6.0, top + 0.65 * row, name, "end"))
        parts.append(
            f'<rect class="c0" x="{left:.1f}" y="{top + 0.1 * row:.1f}" width="{max(long, 1.0):.1f}" '
            f'height="{0.8 * row:.1f}"/>'
        )
        parts.append(_text(left + 6.0 + long, top + 0.65 * row, f"{value:.3g} {unit}", "start"))
    return _svg(title, parts, "", "", height=20.0 + row * len(names))


def ticks(values: Sequence[float]) -> tuple[float, float, list[float]]:
    """Return lower end, upper end and round tick values of an axis that holds some values."""
    low, high = min(values), max(values)
    if high - low <= 1e-9 * max(abs(low), abs(high)):
        spare = 0.1 * abs(high) or 1.0
        low, high = low - spare, high + spare
    raw = (high - low) / 5.0
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(factor * power for factor in (1.0, 2.0, 2.5, 5.0, 10.0) if factor * power >= 0.999 * raw)
    first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    return first * step, last * step, [place * step for place in range(first, last + 1)]


def _svg(
    title: str, parts: Sequence[str], x_label: str, y_label: str, height: float = HEIGHT, top: float = TOP
) -> str:
    frame = []
    if x_label:
        frame.append(_text((LEFT + WIDTH - RIGHT) / 2.0, HEIGHT - 8.0, x_label, "middle"))
        frame.append(_line(LEFT, HEIGHT - BOTTOM, WIDTH - RIGHT, HEIGHT - BOTTOM, "axis"))
    if y_label:
        middle = (top + HEIGHT - BOTTOM) / 2.0
        frame.append(
            f'<text transform="translate(14 {middle:.0f}) rotate(-90)" text-anchor="middle">'
            f"{escape(y_label)}</text>"
        )
        frame.append(_line(LEFT, top, LEFT, HEIGHT - BOTTOM, "axis"))
    body = "".join([*parts, *frame])
    return (
        f'<svg viewBox="0 0 {WIDTH:.0f} {height:.0f}" role="img" aria-label="{escape(title)}">'
        f"<title>{escape(title)}</title>{body}</svg>"
    )


def _legend(series: Sequence[Series]) -> list[str]:
    parts = []
    for place, each in enumerate(series):
        x, y = LEFT + (place % 2) * (WIDTH - LEFT - RIGHT) / 2.0, TOP + 6.0 + 18.0 * (place // 2)
        colour = f"c{each.colour % 6}"
        if each.style == "dots":
            parts.append(f'<circle class="{colour}" cx="{x + 12:.0f}" cy="{y - 4:.0f}" r="4"/>')
        else:
            points = f"{x:.0f},{y - 4:.0f} {x + 24:.0f},{y - 4:.0f}"
            parts.append(f'<polyline class="{colour}" points="{points}"{DASHES[each.style]}/>')
        parts.append(_text(x + 30.0, y, each.label, "start"))
    return parts


def _line(x1: float, y1: float, x2: float, y2: float, kind: str) -> str:
    return f'<line class="{kind}" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>'


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>'


def _number(value: float) -> str:
    return f"{value + 0.0:.6g}"
