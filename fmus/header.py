"""From a model's variable table to C: ``<model>_variables.h`` and the glue's description of it."""

from __future__ import annotations

from fmus.layout import STRING_SLOTS, SlotElement, SlotLayout
from fmus.table import Enumeration, Group, Model, ModelVariable

_C_TYPE = {"real": "double", "integer": "int64_t", "boolean": "int64_t", "enumeration": "int64_t"}
_GLUE_TYPE = {
    "real": "TYPE_REAL",
    "integer": "TYPE_INTEGER",
    "boolean": "TYPE_BOOLEAN",
    "enumeration": "TYPE_ENUMERATION",
    "string": "TYPE_STRING",
}
_GLUE_ACCESS = {
    "parameter": "ACCESS_PARAMETER",
    "input": "ACCESS_INPUT",
    "calculatedParameter": "ACCESS_COMPUTED",
    "output": "ACCESS_COMPUTED",
    "local": "ACCESS_COMPUTED",
}


def variables_header(model: Model) -> str:
    """The C header with ``struct Variables`` and an enum for each enumeration.

    Enumeration items become ``<ENUMERATION>_<ITEM>`` in capitals.
    """
    layout = SlotLayout(model)
    guard = f"{model.name.upper()}_VARIABLES_H"
    lines = [
        f"/* Generated from fmus/{model.name}/variables.py. */",
        f"#ifndef {guard}",
        f"#define {guard}",
        "",
        '#include "model.h"',
        "",
        f"enum {{ MODEL_WORK_BYTES = {model.work_bytes} }};",
        "",
    ]
    for enumeration in layout.enumerations:
        lines += _enumeration(enumeration)
    for name, rows in model.tables.items():
        lines += _table(name, rows)
    lines += ["struct Variables {"]
    lines += _members(model.variables, "    ")
    lines += [
        "};",
        "",
        f"_Static_assert(sizeof(struct Variables) == {8 * layout.slots},",
        '               "one slot of eight bytes per element");',
        "",
        "#endif",
        "",
    ]
    return "\n".join(lines)


def description_source(model: Model, *, token: str, digest: str) -> str:
    """The C file that tells the glue about the variables: types, access, limits, start values.

    ``token`` is the FMI 2 GUID and FMI 3 instantiation token; ``digest`` (32 hex digits) marks
    serialised states.
    """
    layout = SlotLayout(model)
    lines = [
        f"/* Generated from fmus/{model.name}/variables.py. */",
        '#include "instance.h"',
        "",
        f"const char model_name[] = {_string(model.name)};",
        f"const char model_token[] = {_string(token)};",
        f"const char model_array_token[] = {_string(token + '-arrays')};",
        f"const uint64_t model_digest[2] = {{0x{digest[:16]}u, 0x{digest[16:32]}u}};",
        f"const bool model_variable_step = {'true' if model.variable_step else 'false'};",
        f"const uint32_t model_slots = {layout.slots};",
        f"const size_t model_work_bytes = {model.work_bytes};",
        *(
            ()
            if model.state_ends_in_table
            else ("size_t model_state_used(const State *s) { return model_state_size; }",)
        ),
        *(() if model.retunes else ("void model_retune(const Variables *v, State *s) {}",)),
        "",
        f"const Element model_elements[{max(layout.slots, 1)}] = {{",
    ]
    lines += [_element(element) for element in layout.elements]
    lines += ["};", ""]
    strings = [
        f"    {{{element.slot}, {_string(str(element.start))}}},"
        for element in layout.elements
        if element.variable.type == "string" and element.start
    ]
    lines += [
        f"const size_t model_string_starts_count = {len(strings)};",
        f"const StringStart model_string_starts[{max(len(strings), 1)}] = {{",
        *(strings or ["    {0}"]),
        "};",
        "",
    ]
    return "\n".join(lines)


def _element(element: SlotElement) -> str:
    variable = element.variable
    minimum, maximum = "-INFINITY", "INFINITY"
    if variable.type == "enumeration" and variable.enumeration is not None:
        values = [item.value for item in variable.enumeration.items]
        minimum, maximum = repr(float(min(values))), repr(float(max(values)))
    elif variable.type == "boolean":
        minimum, maximum = "0.0", "1.0"
    else:
        if variable.minimum is not None:
            minimum = repr(float(variable.minimum))
        if variable.maximum is not None:
            maximum = repr(float(variable.maximum))
    start = element.start
    if variable.type == "string":
        initial = "0"
    elif variable.type == "real":
        initial = f".real = {float(start or 0.0)!r}"
    else:
        initial = f".integer = {int(start or 0)}"
    access = "ACCESS_TUNABLE" if variable.tunable else _GLUE_ACCESS[variable.causality]
    length = 1
    if variable.is_array:
        length = variable.size if element.index == 0 else 0
    return (
        f"    [{element.slot}] = {{{_string(element.name)}, {_GLUE_TYPE[variable.type]}, "
        f"{access}, {length}, {minimum}, {maximum}, {{{initial}}}}},"
    )


def _enumeration(enumeration: Enumeration) -> list[str]:
    prefix = enumeration.name.upper()
    items = [f"    {prefix}_{item.name.upper()} = {item.value}," for item in enumeration.items]
    return [f"enum {enumeration.name} {{", *items, "};", ""]


def _table(name: str, rows: tuple[tuple[float, ...], ...]) -> list[str]:
    values = ["    {" + ", ".join(map(repr, row)) + "}," for row in rows]
    size = f"[{len(rows)}][{len(rows[0])}]"
    return [f"static const double {name.upper()}{size} = {{", *values, "};", ""]


def _members(members: tuple[ModelVariable | Group, ...], indent: str) -> list[str]:
    lines: list[str] = []
    for member in members:
        if isinstance(member, Group):
            lines.append(f"{indent}struct {{")
            lines += _members(member.members, indent + "    ")
            count = f"[{member.count}]" if member.count is not None else ""
            lines.append(f"{indent}}} {member.name}{count};")
            continue
        size = f"[{member.size}]" if member.size is not None else ""
        if member.type == "string":
            lines.append(f"{indent}char {member.name}{size}[{8 * STRING_SLOTS}];")
        else:
            lines.append(f"{indent}{_C_TYPE[member.type]} {member.name}{size};")
    return lines


def _string(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
