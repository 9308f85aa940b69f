"""The package declares the interface as plait.h does."""

import ctypes
import os
import re

import plait._functions as functions
import plait._structures as structures

HEADER = os.path.join(os.environ["PLAIT_SOURCE"], "c", "include", "plait.h")

C_TYPES = {
    "size_t": ctypes.c_size_t, "uint64_t": ctypes.c_uint64, "int64_t": ctypes.c_int64,
    "uint32_t": ctypes.c_uint32, "int32_t": ctypes.c_int32, "uint8_t": ctypes.c_uint8,
    "double": ctypes.c_double, "char": ctypes.c_char, "plait_component_type": ctypes.c_int32}


def header():
    text = open(HEADER, encoding="utf-8").read()
    return re.sub(r"/\*.*?\*/", " ", text, flags=re.S)


def struct_fields(name):
    """The members of a structure: (name, bytes), or None if the header does not have it."""
    found = re.search(r"typedef struct %s \{(.*?)\} %s;" % (name, name), header(), re.S)
    if not found:
        return None
    fields = []
    for declaration in found.group(1).split(";"):
        declaration = " ".join(declaration.split())
        if not declaration:
            continue
        pointer = "*" in declaration
        kind, names = re.match(r"(?:const )?(\w+)[ *]*(?:const ?\*)? ?(.*)", declaration).groups()
        for each in names.split(","):
            array = re.match(r"\s*(\w+)\s*(?:\[(\d+)\])?", each)
            known = C_TYPES.get(kind) or getattr(structures, kind, None)
            # Other types are those of callbacks.
            size = ctypes.sizeof(ctypes.c_void_p if pointer or known is None else known)
            fields.append((array.group(1), size * int(array.group(2) or 1)))
    return fields


def test_structures_of_the_package_are_those_of_the_header():
    checked = 0
    for name, kind in vars(structures).items():
        if not (isinstance(kind, type) and issubclass(kind, ctypes.Structure)
                and name.startswith("plait_")):
            continue
        own = [(field[0], ctypes.sizeof(field[1])) for field in kind._fields_]
        assert own == struct_fields(name), name
        checked += 1
    assert checked >= 12


def test_functions_of_the_package_are_in_the_header_with_as_many_arguments():
    text = header()
    for name, arguments in {**functions._STATUS, **functions._NOTHING}.items():
        found = re.search(r"PLAIT_API\s+(plait_status|void)\s+%s\(([^;]*)\);" % name, text)
        assert found, name
        declared = [part for part in found.group(2).split(",") if part.strip() != "void"]
        assert len(declared) == len(arguments), name
        assert (found.group(1) == "void") == (name in functions._NOTHING), name
        for part, own in zip(declared, arguments):
            part = " ".join(part.split())
            if "*" not in part and "[" not in part and part.split()[0] in C_TYPES:
                assert ctypes.sizeof(own) == ctypes.sizeof(C_TYPES[part.split()[0]]), (name, part)
            elif "*" in part or "[" in part:
                assert ctypes.sizeof(own) == 8, (name, part)


def test_constants_are_those_of_the_header():
    text = header()
    for name, value in (("PLAIT_ACCESS_UPDATE", structures.ACCESS_UPDATE),
                        ("PLAIT_ACCESS_OVERWRITE", structures.ACCESS_OVERWRITE),
                        ("PLAIT_ACCESS_READ", structures.ACCESS_READ),
                        ("PLAIT_FLOAT32", structures.FLOAT32), ("PLAIT_FLOAT64", structures.FLOAT64)):
        assert int(re.search(name + r" = (\d+)", text).group(1)) == value
    assert int(re.search(r"define PLAIT_DIGEST_BYTES (\d+)", text).group(1)) == \
        structures.DIGEST_BYTES


def test_each_error_code_has_an_exception():
    import plait.errors as errors
    codes = re.findall(r"PLAIT_ERROR_\w+ = (\d+)", header())
    assert sorted(errors.KINDS) == sorted(map(int, codes))
