"""What the schema expects at a place of the vehicle file, in words.

Read from the JSON schema of the models, so that messages can never disagree with the check.
"""

from collections.abc import Sequence
from typing import Any

Step = str | int
JsonSchema = dict[str, Any]
NAME_IN_WORDS = 'a name: a letter, then letters, digits, "_" or "-", at most 48 characters'


def schema_at(root: JsonSchema, path: Sequence[Step]) -> JsonSchema | None:
    """Return the part of a JSON schema that describes the value at `path`, or None."""
    here: JsonSchema | None = _resolved(root, root)
    for step in path:
        if here is None:
            return None
        here = _child(here, step)
        if here is not None:
            here = _resolved(here, root)
    return here


def without_tags(root: JsonSchema, path: Sequence[Step]) -> tuple[Step, ...]:
    """Return `path` without the steps that name a kind of section and are not in the file.

    An error below ``characteristic`` stands at ``characteristic.bollard.thrust_max_n``.
    """
    here: JsonSchema | None = _resolved(root, root)
    kept: list[Step] = []
    for step in path:
        if here is None or step not in _kinds(here):
            kept.append(step)
        here = None if here is None else _child(here, step)
        here = None if here is None else _resolved(here, root)
    return tuple(kept)


def kind_key(schema: JsonSchema | None) -> str:
    """Return the key that tells the kinds of a section apart, or nothing."""
    return str((schema or {}).get("discriminator", {}).get("propertyName", ""))


def keys_of(schema: JsonSchema | None) -> tuple[str, ...]:
    """Return the keys that a section may have; empty where any name may stand."""
    return tuple((schema or {}).get("properties", {}))


def describe(schema: JsonSchema | None, root: JsonSchema) -> str:
    """Say in words what is expected.

    >>> describe({"type": "number", "exclusiveMinimum": 500, "exclusiveMaximum": 1500}, {})
    'a number above 500 and below 1500'
    """
    schema = _resolved(schema or {}, root)
    if "enum" in schema or "const" in schema:
        values = schema.get("enum", [schema.get("const")])
        return "one of " + ", ".join(str(value) for value in values)
    kind = schema.get("type")
    if kind in ("number", "integer"):
        return _number(schema)
    if kind == "array":
        return _list(schema, root)
    if kind == "object" or _kinds(schema):
        return _section(schema, root)
    if "pattern" in schema:
        return NAME_IN_WORDS
    return {"string": "text", "boolean": "true or false"}.get(str(kind), "")


def _section(schema: JsonSchema, root: JsonSchema) -> str:
    if _kinds(schema):
        return f"a section with {kind_key(schema)}: {' or '.join(_kinds(schema))}"
    if "properties" in schema:
        return f"a section with the keys {', '.join(schema['properties'])}"
    inner = _of_any_name(schema)
    return "a section" if inner is None else f"names, each with {describe(inner, root)}"


def _resolved(schema: JsonSchema, root: JsonSchema) -> JsonSchema:
    """Follow references and drop the null of an optional value."""
    while True:
        if "$ref" in schema:
            schema = root["$defs"][schema["$ref"].rpartition("/")[2]]
        elif "anyOf" in schema:
            kept = [part for part in schema["anyOf"] if part.get("type") != "null"]
            if len(kept) != 1:
                return schema
            schema = kept[0]
        else:
            return schema


def _kinds(schema: JsonSchema) -> dict[str, str]:
    """Return the kinds of a section with a discriminator, each with its reference."""
    kinds: dict[str, str] = schema.get("discriminator", {}).get("mapping", {})
    return kinds


def _child(schema: JsonSchema, step: Step) -> JsonSchema | None:
    if step in _kinds(schema):
        return {"$ref": _kinds(schema)[str(step)]}
    if isinstance(step, int):
        prefix = schema.get("prefixItems", [])
        child = prefix[step] if step < len(prefix) else schema.get("items")
    else:
        child = schema.get("properties", {}).get(step, _of_any_name(schema))
    return child if isinstance(child, dict) else None


def _of_any_name(schema: JsonSchema) -> JsonSchema | None:
    """Return what a mapping with free names holds under each of them."""
    for inner in (
        schema.get("additionalProperties"),
        *schema.get("patternProperties", {}).values(),
    ):
        if isinstance(inner, dict):
            return inner
    return None


def _number(schema: JsonSchema) -> str:
    text = "a whole number" if schema["type"] == "integer" else "a number"
    low, high = schema.get("minimum"), schema.get("maximum")
    above, below = schema.get("exclusiveMinimum"), schema.get("exclusiveMaximum")
    bounds = [
        f"{word} {value:g}"
        for word, value in (
            ("above", above),
            ("of at least", low),
            ("below", below),
            ("at most", high),
        )
        if value is not None
    ]
    return " ".join([text, " and ".join(bounds)]) if bounds else text


def _list(schema: JsonSchema, root: JsonSchema) -> str:
    prefix = schema.get("prefixItems")
    if prefix:
        one = describe(prefix[0], root).removeprefix("a ")
        if one.startswith("list"):
            return f"a list of {len(prefix)} rows, each a {one}"
        many = one.replace("number", "numbers", 1) if "number" in one else f"{one}s"
        return f"a list of {len(prefix)} {many} in square brackets"
    return f"a list, each entry {describe(schema.get('items'), root)}"
