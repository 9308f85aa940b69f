"""Builds the package, by the interface of PEP 517, from this folder and a built libplait. It needs
nothing but Python, so `pip install ./python` and `python3 -m build` work without a network.

The library is the file that PLAIT_LIBRARY names, or that of build/release. It becomes a part of the
wheel. Its own libraries (TBB, fmt, zstd, ...) do not: they come from the system, or from `auditwheel
repair`."""

import base64
import hashlib
import os
import pathlib
import sysconfig
import tarfile
import zipfile

HERE = pathlib.Path(__file__).parent
LIBRARY = "libplait.so.0"
# The same as in pyproject.toml, which Python reads from 3.11 on.
NAME, VERSION = "plait", "0.1.0"
METADATA = f"""Metadata-Version: 2.1
Name: {NAME}
Version: {VERSION}
Summary: Meshes far larger than memory, as numpy arrays
License: Apache-2.0
License-File: LICENSE
Requires-Python: >=3.9
Requires-Dist: numpy
"""
ENTRY_POINTS = """[pyvista.readers]
.plait = plait.vtk:read_for_pyvista
"""


def _library():
    named = os.environ.get("PLAIT_LIBRARY")
    for path in [pathlib.Path(named)] if named else [
            HERE / "plait" / LIBRARY, HERE.parent / "build" / "release" / LIBRARY]:
        if path.exists():
            return path.resolve()
    raise FileNotFoundError(
        "libplait was not found: build it (cmake --preset release && cmake --build --preset release "
        "--target plait), or name the file by PLAIT_LIBRARY")


def _sources():
    return sorted(path for path in (HERE / NAME).rglob("*")
                  if path.suffix in (".py", ".pyi", ".typed") or path.name == "py.typed")


def _license():
    """Beside this file in a source archive, one folder up in plait's own."""
    for path in (HERE / "LICENSE", HERE.parent / "LICENSE"):
        if path.exists():
            return path
    raise FileNotFoundError(f"LICENSE was not found in {HERE} or in the folder above it")


def _info_directory():
    return f"{NAME}-{VERSION}.dist-info"


def _tag():
    return "py3-none-" + sysconfig.get_platform().replace("-", "_").replace(".", "_")


def _write_wheel(file, contents):
    """A wheel has a list of its files with their digests."""
    info = _info_directory()
    contents = dict(contents)
    contents[f"{info}/METADATA"] = METADATA.encode()
    contents[f"{info}/LICENSE"] = _license().read_bytes()
    contents[f"{info}/entry_points.txt"] = ENTRY_POINTS.encode()
    contents[f"{info}/WHEEL"] = (f"Wheel-Version: 1.0\nGenerator: {NAME}\nRoot-Is-Purelib: false\n"
                                 f"Tag: {_tag()}\n").encode()
    record = []
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as wheel:
        for name, data in contents.items():
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record.append(f"{name},sha256={digest},{len(data)}")
            entry = zipfile.ZipInfo(name, (2020, 1, 1, 0, 0, 0))  # the same bytes each time
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            wheel.writestr(entry, data)
        record.append(f"{info}/RECORD,,")
        wheel.writestr(f"{info}/RECORD", "\n".join(record) + "\n")


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Writes the wheel, with the library inside, and returns its name."""
    name = f"{NAME}-{VERSION}-{_tag()}.whl"
    contents = {str(path.relative_to(HERE)): path.read_bytes() for path in _sources()}
    contents[f"{NAME}/{LIBRARY}"] = _library().read_bytes()
    _write_wheel(pathlib.Path(wheel_directory) / name, contents)
    return name


def build_sdist(sdist_directory, config_settings=None):
    """Writes the source archive. It has the library too, so that a wheel can be made of it."""
    name = f"{NAME}-{VERSION}.tar.gz"
    top = f"{NAME}-{VERSION}"
    with tarfile.open(pathlib.Path(sdist_directory) / name, "w:gz", format=tarfile.PAX_FORMAT) as archive:
        for path in [*_sources(), HERE / "pyproject.toml", HERE / "plait_build.py"]:
            archive.add(path, f"{top}/{path.relative_to(HERE)}")
        archive.add(_library(), f"{top}/{NAME}/{LIBRARY}")
        archive.add(_license(), f"{top}/LICENSE")
        _add_text(archive, f"{top}/PKG-INFO", METADATA)
    return name


def _add_text(archive, name, text):
    import io
    entry = tarfile.TarInfo(name)
    entry.size = len(text.encode())
    archive.addfile(entry, io.BytesIO(text.encode()))
