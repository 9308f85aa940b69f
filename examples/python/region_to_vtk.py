#!/usr/bin/env python3
"""Writes the part of a surface that is in a box for ParaView, with its normals.

    region_to_vtk.py STORE OUT.vtp LOW HIGH [LEVEL]      such as 0,0,0 1,1,1 4

The file is a VTK XML file of polygons with raw appended data and 64-bit counts (VTK User's Guide,
"VTK XML formats"). It needs no VTK to write.
"""

import struct
import sys

import numpy as np
import plait


def write_vtp(file, vertices, triangles, attributes):
    """Writes a mesh: each array is its number of bytes and then its bytes."""
    parts, at = [], 0

    def array(name, values, kind):
        nonlocal at
        values = np.ascontiguousarray(values)
        parts.append(struct.pack("<Q", values.nbytes) + values.tobytes())
        components = values.shape[1] if values.ndim == 2 else 1
        text = (f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" '
                f'format="appended" offset="{at}"/>')
        at += len(parts[-1])
        return text

    kinds = {"f4": "Float32", "f8": "Float64", "i4": "Int32", "u1": "UInt8"}
    data = "".join(array(name, values, kinds[values.dtype.str[1:]])
                   for name, values in attributes.items())
    points = array("Points", vertices, kinds[vertices.dtype.str[1:]])
    polygons = (array("connectivity", triangles.astype("<i8").ravel(), "Int64")
                + array("offsets", np.arange(3, triangles.size + 1, 3, dtype="<i8"), "Int64"))
    with open(file, "wb") as out:
        out.write(
            '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" '
            'header_type="UInt64"><PolyData>'
            f'<Piece NumberOfPoints="{len(vertices)}" NumberOfPolys="{len(triangles)}">'
            f"<PointData>{data}</PointData><Points>{points}</Points><Polys>{polygons}</Polys>"
            '</Piece></PolyData><AppendedData encoding="raw">_'.encode())
        out.writelines(parts)
        out.write(b"</AppendedData></VTKFile>\n")


def main(path, file, low, high, level=None):
    box = [[float(number) for number in corner.split(",")] for corner in (low, high)]
    with plait.open(path) as store:
        names = [name for name in ("normal",) if name in store]
        mesh = store.mesh(None if level is None else int(level), box=box, attributes=names)
    write_vtp(file, mesh.vertices, mesh.triangles, mesh.attributes)
    print(f"{file}: {len(mesh.vertices)} vertices, {len(mesh.triangles)} triangles")


if __name__ == "__main__":
    main(*sys.argv[1:])
