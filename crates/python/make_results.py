"""Writes `python/lostmotion/results.py` from the JSON Schema of the results.

The Rust structs are the schema; this makes typed Python classes of it. Run it with the installed
package after a change of the results: `python make_results.py`. A test holds the file to it.
"""

from __future__ import annotations

import keyword
import textwrap
from pathlib import Path
from typing import Any

import lostmotion

TARGET = Path(__file__).parent / "python" / "lostmotion" / "results.py"

HEAD = '''"""Results as typed values. Made from the JSON Schema of the command's documents by
`make_results.py`: the fields, their units and their meaning are those of the JSON form, in full
precision. A figure that cannot be told is NaN, a part that there is not is ``None``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

'''


def reference(schema: dict[str, Any]) -> str | None:
    """Name of the definition that a schema refers to."""
    target = schema.get("$ref")
    return None if target is None else str(target).rsplit("/", 1)[1]


class Maker:
    def __init__(self, schema: dict[str, Any]) -> None:
        self.definitions: dict[str, Any] = schema["$defs"]
        self.definitions["RunResult"] = schema
        self.classes: list[str] = []
        self.done: set[str] = set()

    def is_class(self, name: str) -> bool:
        return "properties" in self.definitions[name]

    def type_and_reader(self, schema: dict[str, Any]) -> tuple[str, str]:
        """The type of a value in Python, and how it is made of what stands in `value`."""
        name = reference(schema)
        if name is not None:
            if self.is_class(name):
                self.make(name)
                return name, f"{name}.of({{}})"
            # names of things
            return ("str", "_name({})")
        if "anyOf" in schema:
            inner = next(part for part in schema["anyOf"] if part.get("type") != "null")
            kind, reader = self.type_and_reader(inner)
            return f"{kind} | None", reader
        told: str | list[str] = schema.get("type", [])
        kinds = [told] if isinstance(told, str) else told
        optional = "null" in kinds
        known = next((kind for kind in kinds if kind != "null"), "")
        if known == "number":
            return "float", "{}"
        if known == "array":
            items, reader = self.type_and_reader(schema["items"])
            return f"tuple[{items}, ...]", f"tuple({reader.format('item')} for item in {{}})"
        plain = {"string": "str", "integer": "int", "boolean": "bool"}.get(known, "Any")
        return (f"{plain} | None" if optional else plain), "{}"

    def make(self, name: str) -> None:
        if name in self.done:
            return
        self.done.add(name)
        schema = self.definitions[name]
        required = set(schema.get("required", []))
        fields, readers = [], []
        for key, value in schema["properties"].items():
            kind, reader = self.type_and_reader(value)
            attribute = f"{key}_" if keyword.iskeyword(key) else key
            there = f'data["{key}"]'
            if key not in required or "None" in kind:
                missing = "()" if kind.startswith("tuple") else "False" if kind == "bool" else "None"
                if missing == "None" and "None" not in kind:
                    kind += " | None"
                there = f'data.get("{key}")'
                made = reader.format("value")
                if made == "value":
                    made = there if missing == "None" else f'data.get("{key}", {missing})'
                else:
                    made = f"{missing} if (value := {there}) is None else {made}"
            else:
                made = reader.format(there)
            text = " ".join(value.get("description", "").split())
            fields.append((attribute, kind, text))
            readers.append((attribute, made))
        lines = ["@dataclass(frozen=True)", f"class {name}:"]
        lines += doc(schema.get("description", ""), "    ")
        for attribute, kind, text in fields:
            lines.append(f"    {attribute}: {kind}")
            lines += doc(text, "    ")
        lines += ["", "    @classmethod", f"    def of(cls, data: Mapping[str, Any]) -> {name}:"]
        lines += ['        """From the form that `Run.to_dict` has."""', "        return cls("]
        lines += [f"            {attribute}={made}," for attribute, made in readers]
        lines += ["        )"]
        self.classes.append("\n".join(lines))

    def text(self) -> str:
        self.make("RunResult")
        name = (
            "def _name(value: Any) -> str:\n"
            '    """A name, or the name of a kind with what it is of: ``reversal of X``."""\n'
            "    if isinstance(value, Mapping):\n"
            '        return " of ".join(map(str, value.values()))\n'
            "    return str(value)"
        )
        names = "".join(f'    "{name}",\n' for name in sorted(self.done))
        listed = f"__all__ = [\n{names}]"
        return HEAD + "\n\n\n".join([listed, name, *self.classes]) + "\n"


def doc(text: str, indent: str) -> list[str]:
    text = " ".join(text.split()).replace("\\", "\\\\").replace('"""', "'''")
    if not text:
        return []
    lines = textwrap.wrap(text, 94)
    quoted = f'"""{lines[0]}' + "".join(f"\n{line}" for line in lines[1:])
    quoted += '"""' if len(lines) == 1 else '\n"""'
    return [indent + line for line in quoted.split("\n")]


def results() -> str:
    """The text of the file."""
    return Maker(lostmotion.schema("comparison")).text()


if __name__ == "__main__":
    TARGET.write_text(results(), encoding="utf-8")
