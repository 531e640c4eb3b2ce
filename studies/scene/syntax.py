"""Syntax errors of a scene file in plain sentences that say what to write."""

import re

VALUE = re.compile(r"^\s*(?P<key>[^=#]*?)\s*=\s*(?P<value>.*?)\s*(?:#.*)?$")
POSITION = re.compile(r"\s*\(at (?:line (\d+), column (\d+)|end of document)\)")
NUMBER = r"[+-]?(?:\d[\d_]*\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
CURLY = "\N{LEFT DOUBLE QUOTATION MARK}\N{RIGHT DOUBLE QUOTATION MARK}\N{DOUBLE LOW-9 QUOTATION MARK}"


def explained(text: str, error: Exception) -> tuple[int, str]:
    """Return the line of a syntax error (from 1) and a sentence that says what to write.

    ``text``: the document; ``error``: that of the parser.

    Examples
    --------
    >>> import tomllib
    >>> try:
    ...     tomllib.loads("friction = .15")
    ... except tomllib.TOMLDecodeError as error:
    ...     explained("friction = .15", error)
    (1, 'a number needs a digit before its point: write 0.15')
    """
    match = POSITION.search(str(error))
    lines = text.splitlines() or [""]
    number = int(match[1]) if match and match[1] else len(lines)
    message = POSITION.sub("", str(error)).strip()[:160]
    line = lines[min(number, len(lines)) - 1]
    advice = _advice(line, message)
    if advice is None and number > 1 and not line.strip():
        number, line = number - 1, lines[number - 2]  # the parser stops at the line after an unfinished one
        advice = _advice(line, message)
    quoted = " ".join(line.split())[:60]
    return number, advice or f"is not TOML: {message[:1].lower()}{message[1:]}, in {quoted!r}"


def _advice(line: str, message: str) -> str | None:
    if message.startswith(("Cannot overwrite", "Cannot declare", "Cannot mutate", "Cannot redefine")):
        name = line.strip().split("=")[0].strip()
        return f"{name} is given twice: keep one of the two (several transducers are written [[transducer]])"
    if any(quote in line for quote in CURLY):
        return 'text stands between straight quotes: write "..."'
    if line.strip().startswith("[") and "=" not in line:
        return "the name of a block stands alone in its line between brackets: write [slider] or [[transducer]]"
    match = VALUE.match(line)
    if match is None:
        return f"a line is KEY = VALUE, a [block] or a # comment, got {' '.join(line.split())[:40]!r}"
    return _value_advice(match["key"], match["value"])


def _value_advice(key: str, value: str) -> str | None:
    if not value:
        return f"{key} has no value after the ="
    if value.strip("[] ") in ("True", "False", "TRUE", "FALSE"):
        return f"write {value.lower()}, in lower case"
    for pattern, advice in (
        (r"(?<![\d.])\.\d+(?:[eE][+-]?\d+)?", "a number needs a digit before its point: write 0{}"),
        (r"\d+\.(?![\d])", "a number needs a digit after its point: write {}0"),
    ):
        match = re.search(pattern, re.sub(r'"[^"]*"|\'[^\']*\'', "", value))
        if match:
            return advice.format(match[0])
    if re.fullmatch(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?", value):
        return f"a decimal point, not a comma: write {value.replace(',', '.')}"
    match = re.fullmatch(rf"({NUMBER})\s*([^\W\d][^\s,\"']*(?:\s+[^\W\d][^\s,\"']*)*)", value)
    if match:
        return f'a number with a unit stands between quotes: write {key} = "{match[1]} {match[2]}"'
    if value.count('"') % 2 or (value.count("'") % 2 and '"' not in value):
        return "a text between quotes is not closed in its line"
    if value.count("[") > value.count("]"):
        return "a list is not closed: its ] is missing"
    if re.fullmatch(r"[A-Za-z][\w\- ()/]*", value):
        return f'text stands between quotes: write {key} = "{value}"'
    return None
