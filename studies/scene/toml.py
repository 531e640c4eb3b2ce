"""A table as a TOML document (tomllib only reads)."""

import json
import re


def document(table: dict, *, remarks: tuple[str, ...] = (), beside: dict[str, str] | None = None) -> str:
    """Return the TOML text of a table; every number is written so that it is read back bit for bit.

    ``table``: of text, numbers, booleans, lists, tables and lists of tables; ``remarks``: comment lines at the top;
    ``beside``: comments by dotted key, lists numbered from 0.
    """
    lines = [f"# {remark}" for remark in remarks]
    return "\n".join(lines + _block((), table, beside or {})) + "\n"


def _block(path: tuple[str, ...], table: dict, beside: dict[str, str], number: str = "") -> list[str]:
    lines, dotted = [], "".join(f"{name}." for name in (*path, number) if name)
    for key, value in table.items():
        if not _is_block(value):
            remark = beside.get(f"{dotted}{key}")
            lines.append(f"{_key(key)} = {_value(value)}{'' if remark is None else f'  # {remark}'}")
    for key, value in table.items():
        here = (*path, _key(key))
        if isinstance(value, dict):
            lines += ["", f"[{'.'.join(here)}]", *_block(here, value, beside)]
        elif _is_block(value):
            for k, entry in enumerate(value):
                lines += ["", f"[[{'.'.join(here)}]]", *_block(here, entry, beside, str(k))]
    return lines


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else json.dumps(key, ensure_ascii=False)


def _is_block(value) -> bool:
    return isinstance(value, dict) or (isinstance(value, list) and bool(value) and isinstance(value[0], dict))


def _value(value) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)  # its escapes are TOML's
    if isinstance(value, list):
        return f"[{', '.join(_value(entry) for entry in value)}]"
    return repr(value)
