"""Sums and signs of texts: numbers, names or arithmetic. Sums of numbers are exact."""

from decimal import Decimal, InvalidOperation

from ..spacar.arithmetic import is_number


def plus(a: str, b: str) -> str:
    """Sum a + b."""
    x, y = _decimal(a), _decimal(b)
    if x is not None and y is not None:
        return _text(x + y)
    if x == 0:
        return b
    if y == 0:
        return a
    if b.startswith("-") and _is_term(b[1:]):
        return f"{a} - {b[1:]}"
    return f"{a} + {_term(b, signs=True)}"


def minus(a: str, b: str) -> str:
    """Difference a - b."""
    return plus(a, negated(b))


def negated(a: str) -> str:
    """-a."""
    if (x := _decimal(a)) is not None:
        return _text(-x)
    if a.startswith("-") and _is_term(a[1:]):
        inner = a[1:]
        return inner[1:-1] if inner.startswith("(") else inner
    return f"-{_term(a)}"


def times(a: str, b: str) -> str:
    """Product a * b."""
    x, y = _decimal(a), _decimal(b)
    if x is not None and y is not None:
        return _text(x * y)
    if 0 in (x, y):
        return "0"
    if x == 1 or y == 1:
        return b if x == 1 else a
    return f"{_term(a)}*{_term(b)}"


def reflected(a: str, at: str) -> str:
    """2 at - a."""
    return minus(times("2", at), a)


def between(a: str, b: str, place: str) -> str:
    """Text of a + place (b - a)."""
    return a if a.strip() == b.strip() else plus(a, times(place, minus(b, a)))


def _decimal(text: str) -> Decimal | None:
    if not is_number(text):
        return None
    try:
        found = Decimal("".join(text.split()))
    except InvalidOperation:
        return None
    return found if found.is_finite() else None


def _text(number: Decimal) -> str:
    """Short text of a number."""
    if number == 0:
        return "0"
    # A sum of numbers of different size has more digits than a float.
    rounded = Decimal(repr(float(number))) if len(number.as_tuple().digits) > 17 else number
    short = rounded.normalize()
    return format(short, "f") if -7 <= short.adjusted() <= 9 else str(short).replace("E+", "e").replace("E", "e")


def _is_term(text: str) -> bool:
    """Whether a text is one name, one number, or one parenthesis."""
    if text.strip().isidentifier() or (is_number(text) and not text.strip().startswith(("-", "+"))):
        return True
    if not text.startswith("(") or not text.endswith(")"):
        return False
    depth = 0
    for k, sign in enumerate(text):
        depth += (sign == "(") - (sign == ")")
        if depth == 0:
            return k == len(text) - 1
    return False


def _term(text: str, *, signs: bool = False) -> str:
    """A text as a factor, or with ``signs`` as a summand."""
    if _is_term(text) or (signs and not text.strip().startswith(("-", "+"))):
        return text
    return f"({text})"
