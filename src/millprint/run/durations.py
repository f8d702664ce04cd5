"""A time in words."""


def duration(seconds: float) -> str:
    """A time in words: 40 s, 3 min 20 s, 40 min, 2 h 5 min."""
    minutes, rest = divmod(round(seconds), 60)
    if not minutes:
        return f"{rest} s"
    hours, left = divmod(minutes, 60)
    if hours:
        return f"{hours} h {left} min"
    return f"{minutes} min" if minutes >= 10 else f"{minutes} min {rest} s"
