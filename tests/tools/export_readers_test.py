"""What `plait export` writes, read back by readers of these tests and by those of other people."""

import json
import os
import re
import shutil
import struct
import subprocess
import urllib.parse
import xml.etree.ElementTree

import numpy as np
import plait
import pytest
from conftest import icosahedron, make, sheet

PROGRAM = os.environ.get("PLAIT_PROGRAM", "")
pytestmark = pytest.mark.skipif(not os.path.exists(PROGRAM), reason="the program was not built")

LEVEL = 3
PART = ["--faces", "1,4-6,11"]  # patches that share sides, corners and nothing
PART_FACES = [1, 4, 5, 6, 11]
VTK_TYPES = {"Float32": "<f4", "Float64": "<f8", "Int32": "<i4", "Int64": "<i8", "UInt8": "|u1",
             "UInt16": "<u2", "UInt64": "<u8"}
GLTF_TYPES = {5120: "|i1", 5121: "|u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
GLTF_SHAPES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def export(store, out, *options, refused=False, warning=None):
    """Runs the program and returns its report, or its message. It warns of `warning` or of nothing."""
    done = subprocess.run([PROGRAM, "export", store, out, "--json", *options], capture_output=True,
                          text=True, check=False)
    assert done.returncode == (2 if refused else 0), done.stderr
    if refused:
        return done.stderr
    assert (warning in done.stderr) if warning else not done.stderr
    return json.loads(done.stdout)


def linear(srgb):
    """IEC 61966-2-1."""
    srgb = np.asarray(srgb, float)
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def in_the_world(document, points):
    """Positions of a glTF file as a reader with doubles has them."""
    node, = document["nodes"]
    return points * np.array(node.get("scale", [1, 1, 1]), float) + node.get("translation", [0, 0, 0])


def read_vtp(path):
    """Points, triangles, arrays of points and arrays of triangles."""
    content = open(path, "rb").read()
    cut = content.index(b"_", content.index(b'<AppendedData encoding="raw">')) + 1
    end = content.rindex(b"</AppendedData>")
    root = xml.etree.ElementTree.fromstring(content[:cut] + content[end:])
    assert root.get("header_type") == "UInt64" and root.get("byte_order") == "LittleEndian"
    data, used = content[cut:end], []

    def array(element):
        offset = int(element.get("offset"))
        size, = struct.unpack_from("<Q", data, offset)
        used.append((offset, offset + 8 + size))
        records = np.frombuffer(data, VTK_TYPES[element.get("type")], offset=offset + 8,
                                count=size // np.dtype(VTK_TYPES[element.get("type")]).itemsize)
        width = int(element.get("NumberOfComponents", 1))
        return records.reshape(-1, width) if width > 1 else records

    piece = root.find("PolyData/Piece")
    points = array(piece.find("Points/DataArray"))
    polys = {each.get("Name"): array(each) for each in piece.findall("Polys/DataArray")}
    named = [{each.get("Name"): array(each) for each in piece.findall(kind + "/DataArray")}
             for kind in ("PointData", "CellData")]
    triangles = polys["connectivity"].reshape(-1, 3)
    assert (polys["offsets"] == 3 * np.arange(1, len(triangles) + 1)).all()
    assert len(points) == int(piece.get("NumberOfPoints"))
    assert len(triangles) == int(piece.get("NumberOfPolys"))
    used.sort()
    assert used[0][0] == 0 and all(a[1] == b[0] for a, b in zip(used, used[1:]))
    assert data[used[-1][1]:].strip() == b""
    return points, triangles, *named


def read_gltf(path):
    """The document, and for each primitive its attributes by name and its indices."""
    content = open(path, "rb").read()
    if content[:4] == b"glTF":
        version, length, size = struct.unpack_from("<III", content, 4)
        assert version == 2 and length == len(content) and content[16:20] == b"JSON"
        document = json.loads(content[20:20 + size])
        numbers, kind = struct.unpack_from("<I4s", content, 20 + size)
        assert kind == b"BIN\0" and numbers % 4 == 0 and 28 + size + numbers == length
        data = content[28 + size:]
        assert "uri" not in document["buffers"][0]
    else:
        document = json.loads(content)
        uri = document["buffers"][0]["uri"]
        name = urllib.parse.unquote(uri)
        assert uri == urllib.parse.quote(name)
        data = open(os.path.join(os.path.dirname(path), name), "rb").read()
    assert document["buffers"][0]["byteLength"] == len(data)

    def array(number):
        accessor = document["accessors"][number]
        view = document["bufferViews"][accessor["bufferView"]]
        dtype, width = np.dtype(GLTF_TYPES[accessor["componentType"]]), GLTF_SHAPES[accessor["type"]]
        stride = view.get("byteStride", dtype.itemsize * width)
        first = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        assert first % 4 == 0 and stride % dtype.itemsize == 0
        last = accessor.get("byteOffset", 0) + stride * (accessor["count"] - 1)
        assert last + dtype.itemsize * width <= view["byteLength"]
        records = np.lib.stride_tricks.as_strided(
            np.frombuffer(data, dtype, offset=first, count=1), (accessor["count"], width),
            (stride, dtype.itemsize))
        if "min" in accessor:
            assert (records.min(0) == np.array(accessor["min"])).all()
            assert (records.max(0) == np.array(accessor["max"])).all()
        if accessor.get("normalized"):
            records = np.maximum(records / np.iinfo(dtype).max, -1)
        return records if width > 1 else records[:, 0]

    mesh, = document["meshes"]
    return document, [({name: array(number) for name, number in each["attributes"].items()},
                       array(each["indices"]).astype(np.int64)) for each in mesh["primitives"]]


def corners_of(points, triangles):
    """The triangles as coordinates, in an order that depends on nothing else."""
    corners = np.asarray(points)[np.asarray(triangles)].reshape(-1, 9)
    return corners[np.lexsort(corners.T)]


def same_surface(points, triangles, mesh):
    """The same vertices and triangles as those of store.mesh(), to the last bit."""
    assert len(triangles) == len(mesh.triangles)
    assert np.array_equal(np.unique(points, axis=0), np.unique(mesh.vertices, axis=0))
    assert np.array_equal(corners_of(points, triangles), corners_of(mesh.vertices, mesh.triangles))


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    """A closed surface and one with a border: normals, colours, and attributes of other types."""
    folder = tmp_path_factory.mktemp("export")
    paths = {}
    for name, mesh in (("ball", icosahedron()), ("sheet", sheet(3))):
        paths[name] = folder / f"{name}.plait"
        with make(mesh, paths[name], levels=LEVEL, scheme="loop", normals=True,
                  block_bytes=4096) as store:
            store.add_attribute("color", np.uint8, 3)
            store.add_attribute("height", np.float32)
            store.add_attribute("wide", np.float64, 2)

            def fill(vertices):
                z = vertices["position"][:, 2]
                vertices["height"][:] = z
                vertices["wide"][:] = np.stack([z, -z], 1)
                vertices["color"][:] = np.abs(vertices["position"] * 50).astype(np.uint8)

            store.visit(fill, reads=["position"], writes=["height", "wide", "color"])
            store.commit()
    return paths


@pytest.mark.parametrize("name", ["ball", "sheet"])
@pytest.mark.parametrize("part", [[], PART])
def test_vtp_has_the_bits_of_the_store(stores, tmp_path, name, part):
    store, out = stores[name], tmp_path / "out.vtp"
    report = export(store, out, *part, "--attribute", "normal,color,wide,height")
    points, triangles, of_points, of_triangles = read_vtp(out)
    assert not of_triangles and list(of_points) == ["normal", "color", "wide", "height"]
    with plait.open(store) as opened:
        mesh = opened.mesh(faces=PART_FACES if part else None, attributes=list(of_points))
    same_surface(points, triangles, mesh)
    assert len(points) == len(mesh.vertices) == report["vertices"]
    assert report["patches"] == (5 if part else len(mesh.faces))
    order, expected = np.lexsort(points.T), np.lexsort(mesh.vertices.T)
    for each, records in of_points.items():
        assert records.dtype == mesh.attributes[each].dtype
        assert np.array_equal(records[order], mesh.attributes[each][expected])


def test_whole_level_is_in_the_order_of_ply(stores, tmp_path):
    export(stores["ball"], tmp_path / "out.vtp")
    export(stores["ball"], tmp_path / "out.off")
    points, triangles, *_ = read_vtp(tmp_path / "out.vtp")
    with plait.open(stores["ball"]) as store:
        # Vertices come level by level, each level in the order of its array.
        levels = np.concatenate([store["position"][level][:] for level in store.levels])
    assert np.array_equal(points, levels)
    words = open(tmp_path / "out.off", encoding="ascii").read().split()
    assert words[:4] == ["OFF", str(len(points)), str(len(triangles)), "0"]
    numbers = np.array(words[4:4 + points.size], np.float32).reshape(-1, 3)
    assert np.array_equal(numbers, points)
    assert np.array_equal(np.array(words[4 + points.size:], int).reshape(-1, 4)[:, 1:], triangles)


def test_pieces_of_pvtp_together_are_the_surface(stores, tmp_path):
    out = tmp_path / "a & b.pvtp"
    export(stores["ball"], out, "--pieces", "3", "--attribute", "normal,wide")
    root = xml.etree.ElementTree.parse(out).getroot()
    assert [each.get("Name") for each in root.iter("PDataArray")] == ["normal", "wide", "Points"]
    names = [each.get("Source") for each in root.iter("Piece")]
    assert names == [f"a & b_{piece}.vtp" for piece in range(3)]
    points, triangles, first = [], [], 0
    for name in names:
        piece = read_vtp(tmp_path / name)
        points.append(piece[0])
        triangles.append(piece[1] + first)
        first += len(piece[0])
    with plait.open(stores["ball"]) as store:
        same_surface(np.concatenate(points), np.concatenate(triangles), store.mesh())
    assert sorted(os.listdir(tmp_path)) == sorted(names + [out.name])


def test_pvtp_with_fewer_pieces_leaves_none_of_the_older_ones(stores, tmp_path):
    out = tmp_path / "a.pvtp"
    export(stores["ball"], out, "--pieces", "6")
    export(stores["ball"], tmp_path / "a_4.vtp", "--force")  # no piece: the user exported it
    (tmp_path / "a_5.vtp").rename(tmp_path / "a_7.vtp")  # no name of this piece
    (tmp_path / "a_5.vtp").symlink_to(tmp_path / "a_3.vtp")
    export(stores["ball"], tmp_path / "b.pvtp", "--pieces", "4")
    assert export(stores["ball"], out, "--pieces", "2", refused=True)
    assert export(stores["ball"], out, "--pieces", "2", "--force", "--attribute", "nothing",
                  refused=True)
    assert (tmp_path / "a_3.vtp").exists()
    export(stores["ball"], out, "--pieces", "2", "--force")
    root = xml.etree.ElementTree.parse(out).getroot()
    assert [each.get("Source") for each in root.iter("Piece")] == ["a_0.vtp", "a_1.vtp"]
    left = ["a.pvtp", "a_0.vtp", "a_1.vtp", "a_4.vtp", "a_5.vtp", "a_7.vtp"]
    assert sorted(os.listdir(tmp_path)) == left + ["b.pvtp"] + [f"b_{k}.vtp" for k in range(4)]


@pytest.mark.parametrize("name", ["ball", "sheet"])
@pytest.mark.parametrize("ending,part", [(".glb", []), (".glb", PART), (".gltf", PART)])
def test_gltf_has_the_patches_of_the_store(stores, tmp_path, name, ending, part):
    store, out = stores[name], tmp_path / ("out é" + ending)
    report = export(store, out, *part, "--attribute", "normal,color,height")
    document, primitives = read_gltf(out)
    assert "extensionsUsed" not in document
    with plait.open(store) as opened:
        mesh = opened.mesh(faces=PART_FACES if part else None)
        patches = {each: opened.patches(mesh.faces, attribute=each).records
                   for each in ("position", "normal", "color", "height")}
    (attributes, indices), = primitives
    assert np.array_equal(attributes["POSITION"], patches["position"].reshape(-1, 3))
    assert np.array_equal(attributes["NORMAL"], patches["normal"].reshape(-1, 3))
    assert np.abs(attributes["COLOR_0"] - linear(patches["color"].reshape(-1, 3) / 255)).max() < 1e-5
    assert np.array_equal(attributes["_height"], patches["height"].ravel())
    same_surface(attributes["POSITION"], indices.reshape(-1, 3), mesh)
    assert report["vertices"] == len(attributes["POSITION"])
    assert report["left_out"] == ["wide"]
    assert export(store, tmp_path / "no.glb", "--attribute", "wide", refused=True)


def test_groups_of_gltf_share_their_indices(tmp_path):
    """More vertices than 16 bits can number: all primitives but the last have one accessor."""
    make(sheet(8), tmp_path / "s.plait", levels=6).close()
    export(tmp_path / "s.plait", tmp_path / "s.glb")
    document, primitives = read_gltf(tmp_path / "s.glb")
    used = [each["indices"] for each in document["meshes"][0]["primitives"]]
    assert len(used) == 5 and used == [0, 0, 0, 0, 1]
    assert document["accessors"][0]["bufferView"] == document["accessors"][1]["bufferView"] == 0
    assert all(indices.max() < 65535 for _, indices in primitives)
    first, points, triangles = 0, [], []
    for attributes, indices in primitives:
        points.append(attributes["POSITION"])
        triangles.append(indices.reshape(-1, 3) + first)
        first += len(points[-1])
    with plait.open(tmp_path / "s.plait") as store:
        same_surface(np.concatenate(points), np.concatenate(triangles), store.mesh())


@pytest.mark.parametrize("name", ["ball", "sheet"])
def test_quantized_gltf_has_one_lattice(stores, tmp_path, name):
    report = export(stores[name], tmp_path / "q.glb", "--quantize", "--attribute", "normal")
    document, ((attributes, indices),) = read_gltf(tmp_path / "q.glb")
    assert document["extensionsRequired"] == ["KHR_mesh_quantization"]
    node, = document["nodes"]
    step = node["scale"][0]
    assert node["scale"] == [step] * 3 and np.frexp(step)[0] == 0.5
    points = attributes["POSITION"] * step + np.array(node["translation"])
    with plait.open(stores[name]) as store:
        mesh = store.mesh()
        exact = store.patches(mesh.faces).records.reshape(-1, 3)
        normals = store.patches(mesh.faces, attribute="normal").records.reshape(-1, 3)
    assert attributes["POSITION"].dtype == np.uint16
    assert 32767 < attributes["POSITION"].max() <= 65535
    assert report["position_error"] == np.abs(points - exact).max()
    assert report["position_error"] <= step / 2
    assert report["moved"] == (points != exact).any(1).sum()
    assert np.abs(attributes["NORMAL"] - normals).max() <= 0.5 / 127 + 1e-6
    # Patches have equal numbers where they meet, so they have no cracks.
    assert len(np.unique(points, axis=0)) == len(mesh.vertices)
    assert len(indices) == 3 * len(mesh.triangles)


def test_gltf_has_float32_of_wide_positions_and_texture_from_the_top(tmp_path):
    """assimp/assimp#2849, CesiumGS/obj2gltf#13: textures upside down."""
    with make(icosahedron(), tmp_path / "w.plait", levels=LEVEL, dtype=np.float64) as store:
        store.add_attribute("texture", np.float32, 2)
        store.visit(lambda v: v["position"][:, :2].astype(np.float32), reads=["position"],
                    writes=["texture"])
        store.commit()
        patches = store.patches(range(20)).records.reshape(-1, 3)
    export(tmp_path / "w.plait", tmp_path / "w.glb", "--attribute", "texture")
    _, ((attributes, _),) = read_gltf(tmp_path / "w.glb")
    assert np.array_equal(attributes["POSITION"], patches.astype(np.float32))
    s, t = patches[:, :2].astype(np.float32).T
    assert np.array_equal(attributes["TEXCOORD_0"], np.stack([s, np.float32(1) - t], 1))
    with plait.open(tmp_path / "w.plait", writable=True) as store:
        store.visit(lambda v: np.where(v["position"] == patches.max(), np.inf, v["position"]),
                    reads=["position"], writes=["position"])
        store.commit()
    for options in ([], ["--quantize"]):
        assert "finite" in export(tmp_path / "w.plait", tmp_path / "n.glb", *options, refused=True)
    assert sorted(os.listdir(tmp_path)) == ["w.glb", "w.plait"]


@pytest.mark.parametrize("offset", [[4.5e5, 5.412345e6, 300],
                                    [12958095.124851028, 4865499.469870342, 0]])
def test_gltf_of_wide_positions_far_away_keeps_what_float32_can(tmp_path, offset):
    """Ground in metres of UTM, and of EPSG:3857 (KhronosGroup/glTF#1610, CesiumGS/obj2gltf#267): float32
    would have steps of half a metre there, or of one."""
    offset = np.array(offset)
    vertices, triangles = sheet(3)
    with make((vertices * 0.37 + offset, triangles), tmp_path / "u.plait", levels=LEVEL,
              dtype=np.float64) as store:
        patches = store.patches(range(len(triangles))).records.reshape(-1, 3)
    for options, most in (([], 1e-7), (["--quantize"], 2e-5), (["--up", "z"], 1e-7)):
        report = export(tmp_path / "u.plait", tmp_path / "u.glb", "--force", *options)
        document, ((attributes, _),) = read_gltf(tmp_path / "u.glb")
        points = in_the_world(document, attributes["POSITION"])
        wanted = patches[:, [0, 2, 1]] * [1, 1, -1] if "--up" in options else patches
        assert report["position_error"] == np.abs(points - wanted).max() < most
        translation = document["nodes"][0]["translation"]
        assert len(np.unique(points, axis=0)) == len(np.unique(patches, axis=0))
        if "--quantize" not in options:  # a reader with float32 has the same place
            assert np.array_equal(np.float32(translation), translation)
    # Facets have float32: the report says what that costs.
    report = export(tmp_path / "u.plait", tmp_path / "u.stl")
    narrow = patches.astype(np.float32)
    assert report["position_error"] == np.abs(narrow - patches).max() > 0.1
    with plait.open(tmp_path / "u.plait") as store:
        mesh = store.mesh()
    moved = (mesh.vertices != mesh.vertices.astype(np.float32)).any(1)
    assert report["moved"] == moved[mesh.triangles].any(1).sum() > 0
    told = subprocess.run([PROGRAM, "export", tmp_path / "u.plait", tmp_path / "u.stl", "--force"],
                          capture_output=True, text=True, check=True).stdout
    assert f'{report["moved"]} triangles have coordinates that are off' in told.replace(",", "")
    assert ".ply" in told
    report = export(tmp_path / "u.plait", tmp_path / "u.ply")
    assert report["position_error"] == report["moved"] == 0


@pytest.mark.parametrize("name, dtype, components", [
    ("normal", np.int16, 3), ("normal", np.float32, 2), ("color", np.int8, 3), ("color", np.float32, 2),
    ("texture", np.uint16, 2)])
def test_gltf_says_what_viewers_do_not_draw(tmp_path, name, dtype, components):
    with make(icosahedron(), tmp_path / "s.plait", levels=1) as store:
        store.add_attribute(name, dtype, components)
        with store.patch_writer(name) as writer:
            for face in range(20):
                writer.write_patch(name, face, 1, np.ones((6, components), dtype))
        store.commit()
    export(tmp_path / "s.plait", tmp_path / "s.glb", "--attribute", name,
           warning=f"'{name}' has records of {components} of {np.dtype(dtype)}, so the file has it as "
                   f"_{name}, which viewers do not draw")
    _, ((attributes, _),) = read_gltf(tmp_path / "s.glb")
    assert f"_{name}" in attributes


def test_gltf_with_z_up_is_turned(stores, tmp_path):
    for options in ([], ["--quantize"]):
        export(stores["ball"], tmp_path / "y.glb", "--attribute", "normal", "--force", *options)
        export(stores["ball"], tmp_path / "z.glb", "--attribute", "normal", "--force", "--up", "z",
               *options)
        (_, ((y, _),)), (_, ((z, _),)) = read_gltf(tmp_path / "y.glb"), read_gltf(tmp_path / "z.glb")
        assert np.array_equal(y["NORMAL"][:, [0, 2, 1]] * [1, 1, -1], z["NORMAL"])
        if not options:
            assert np.array_equal(y["POSITION"][:, [0, 2, 1]] * [1, 1, -1], z["POSITION"])
    assert "up 'x'" in export(stores["ball"], tmp_path / "x.glb", "--up", "x", refused=True)


def test_gltf_with_z_up_says_which_vectors_are_not_turned(tmp_path):
    with make(icosahedron(), tmp_path / "s.plait", levels=1) as store:
        store.add_attribute("velocity", np.float32, 3)
        with store.patch_writer("velocity") as writer:
            for face in range(20):
                writer.write_patch("velocity", face, 1, np.ones((6, 3), np.float32))
        store.commit()
    export(tmp_path / "s.plait", tmp_path / "y.glb", "--attribute", "velocity")
    export(tmp_path / "s.plait", tmp_path / "z.glb", "--attribute", "velocity", "--up", "z",
           warning="_velocity has the three numbers of 'velocity' as the store has them")


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_gltf_has_linear_colours(tmp_path, dtype):
    """Integers are sRGB, and floats are linear, if nothing else is asked for. Alpha never changes."""
    most = 1 if dtype == np.float32 else np.iinfo(dtype).max
    made = np.array([0.737, 0.02, 0.5, 0.25]) * most
    with make(icosahedron(), tmp_path / "c.plait", levels=1) as store:
        store.add_attribute("color", dtype, 4)
        store.visit(lambda v: np.tile(made.astype(dtype), (len(v["position"]), 1)),
                    reads=["position"], writes=["color"])
        store.commit()
    stored = made.astype(dtype) / most
    turned = np.append(linear(stored[:3]), stored[3])
    for options, wanted in (([], stored if dtype == np.float32 else turned),
                            (["--colors", "srgb"], turned), (["--colors", "linear"], stored)):
        export(tmp_path / "c.plait", tmp_path / "c.glb", "--attribute", "color", "--force", *options)
        _, ((attributes, _),) = read_gltf(tmp_path / "c.glb")
        assert np.abs(attributes["COLOR_0"] - wanted).max() < 1e-5
    assert export(tmp_path / "c.plait", tmp_path / "n.glb", "--colors", "lab", refused=True)


def test_gltf_has_colours_from_0_to_1_and_says_so(tmp_path):
    """Radiance is often more than 1, and a file with such colours is not valid, or its numbers wrap
    around (KhronosGroup/glTF-Blender-IO#2499)."""
    with make(icosahedron(), tmp_path / "c.plait", levels=1) as store:
        store.add_attribute("color", np.float32, 3)
        store.visit(lambda v: v["position"] * 2, reads=["position"], writes=["color"])
        store.commit()
        colors = store.patches(range(20), attribute="color").records.reshape(-1, 3)
    export(tmp_path / "c.plait", tmp_path / "c.glb", "--attribute", "color",
           warning="42 of 42 vertices have a colour outside 0 to 1")
    _, ((attributes, _),) = read_gltf(tmp_path / "c.glb")
    assert np.array_equal(attributes["COLOR_0"], colors.clip(0, 1))


@pytest.fixture
def own_normals(tmp_path):
    """A store whose normals a test writes."""
    def make_with(change, dtype=np.float32):
        path = tmp_path / f"n{len(os.listdir(tmp_path))}.plait"
        with make(icosahedron(), path, levels=2) as store:
            store.add_attribute("normal", dtype, 3)
            store.visit(lambda v: change(v["position"].astype(dtype)), reads=["position"],
                        writes=["normal"])
            store.commit()
        return path
    return make_with


def test_gltf_has_normals_of_length_1(own_normals, tmp_path):
    store = own_normals(lambda p: p * np.float32(0.001))
    with plait.open(store) as opened:
        records = opened.patches(range(20), attribute="normal").records.reshape(-1, 3).astype(float)
    wanted = records / np.linalg.norm(records, axis=1, keepdims=True)
    for options, most in (([], 1e-7), (["--quantize"], 0.5 / 127 + 1e-6)):
        export(store, tmp_path / "n.glb", "--attribute", "normal", "--force", *options,
               warning="162 of 162 vertices have a normal of another length than 1")
        _, ((attributes, _),) = read_gltf(tmp_path / "n.glb")
        assert np.abs(attributes["NORMAL"] - wanted).max() <= most


@pytest.mark.parametrize("bad", [0, np.nan, np.inf])
def test_gltf_without_normals_where_one_has_no_direction(own_normals, tmp_path, bad):
    def change(p):
        p = p / np.linalg.norm(p, axis=1, keepdims=True)
        p[np.abs(p[:, 0]) < 1e-6] = bad
        return p
    store = own_normals(change)
    with plait.open(store) as opened:
        normals = opened.mesh(attributes=["normal"]).attributes["normal"]
    count = int((~(np.abs(np.linalg.norm(normals, axis=1) - 1) < 0.1)).sum())
    for options in ([], ["--quantize"]):
        report = export(store, tmp_path / "n.glb", "--attribute", "normal", "--force", *options,
                        warning=f"{count} of 162 vertices have a normal without direction")
        assert report["left_out"] == ["normal"]
        _, ((attributes, _),) = read_gltf(tmp_path / "n.glb")
        assert list(attributes) == ["POSITION"]
    export(store, tmp_path / "n.ply", "--attribute", "normal")


def test_normals_that_plait_made_on_faces_without_area_are_left_out(tmp_path):
    vertices, triangles = sheet(2)
    vertices[:, 1:] = 0  # a line
    make((vertices, triangles), tmp_path / "l.plait", levels=2, normals=True).close()
    export(tmp_path / "l.plait", tmp_path / "l.glb", "--attribute", "normal",
           warning="81 of 81 vertices have a normal without direction")


@pytest.mark.parametrize("scale", [1, 1e-30, 1e30])
def test_stl_of_faces_without_area_has_normals_that_are_numbers(tmp_path, scale):
    """LHEEA/meshmagick#13, openscad/openscad#1225: "nan" where two corners of a facet are one point, or
    where a product of two sides is 0 or infinite."""
    vertices, triangles = sheet(2)
    vertices[:, 1] *= vertices[:, 0] > 0.3  # some faces are a line
    make((vertices * scale, triangles), tmp_path / "s.plait", levels=2).close()
    export(tmp_path / "s.plait", tmp_path / "s.stl")
    facets = np.fromfile(tmp_path / "s.stl", offset=84, dtype=[("f", "<f4", 12), ("a", "<u2")])["f"]
    lengths = np.linalg.norm(facets[:, :3].astype(float), axis=1)
    corners = facets[:, 3:].astype(float).reshape(-1, 3, 3) / scale
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    assert np.isfinite(facets).all() and (areas < 1e-6).any() and (areas > 1e-3).any()
    assert np.abs(lengths[areas > 1e-3] - 1).max() < 1e-6
    assert (np.minimum(lengths, np.abs(lengths - 1)) < 1e-6).all()


def test_attributes_of_float64_are_narrowed_on_request(own_normals, tmp_path):
    store = own_normals(lambda p: p / np.linalg.norm(p, axis=1, keepdims=True), np.float64)
    assert "--narrow" in export(store, tmp_path / "n.glb", "--attribute", "normal", refused=True)
    export(store, tmp_path / "n.glb", "--attribute", "normal", "--narrow")
    _, ((attributes, _),) = read_gltf(tmp_path / "n.glb")
    with plait.open(store, writable=True) as opened:
        wanted = opened.patches(range(20), attribute="normal").records.reshape(-1, 3)
        opened.add_attribute("huge", np.float64)
        opened.add_attribute("empty", np.float32)
        opened.visit(lambda v: np.full(len(v["position"]), 1e300), reads=["position"],
                     writes=["huge"])
        opened.visit(lambda v: np.full(len(v["position"]), np.nan, np.float32), reads=["position"],
                     writes=["empty"])
        opened.commit()
    assert attributes["NORMAL"].dtype == np.float32
    assert np.array_equal(attributes["NORMAL"], wanted.astype(np.float32))
    # OBJ has decimals, so it keeps them.
    export(store, tmp_path / "n.obj", "--attribute", "normal")
    lines = open(tmp_path / "n.obj", encoding="ascii").read().splitlines()
    written = np.array([line.split()[1:] for line in lines if line.startswith("vn ")], float)
    assert np.array_equal(np.unique(written, axis=0), np.unique(wanted, axis=0))
    # What float32 has not, or glTF forbids, is refused.
    for name in ("huge", "empty"):
        message = export(store, tmp_path / "h.glb", "--attribute", name, "--narrow", refused=True)
        assert name in message and "finite" in message and ".vtp" in message
        export(store, tmp_path / (name + ".vtp"), "--attribute", name)


def test_box_takes_the_patches_that_meet_it(stores, tmp_path):
    store = stores["ball"]
    export(store, tmp_path / "box.vtp", "--box", "-2,-2,0.6,2,2,2")
    export(store, tmp_path / "box.stl", "--box", "-2,-2,0.6,2,2,2")
    points, triangles, *_ = read_vtp(tmp_path / "box.vtp")
    with plait.open(store) as opened:
        mesh = opened.mesh(box=([-2, -2, 0.6], [2, 2, 2]))
    assert 0 < len(mesh.faces) < 20
    same_surface(points, triangles, mesh)
    facets = np.fromfile(tmp_path / "box.stl", offset=84, dtype=[("f", "<f4", 12), ("a", "<u2")])
    corners = facets["f"][:, 3:]
    assert np.array_equal(corners[np.lexsort(corners.T)],
                          corners_of(mesh.vertices, mesh.triangles))
    before = sorted(os.listdir(tmp_path))
    for options in (["--box", "5,5,5,6,6,6"], ["--box", "1,1,1,0,0,0"], ["--box", "1,2,3"],
                    ["--faces", "20"], ["--faces", "3-1"], ["--faces", ""], ["--quantize"],
                    ["--pieces", "2"], ["--narrow"], ["--up", "z"], ["--colors", "srgb"]):
        assert export(store, tmp_path / "no.vtp", *options, refused=True)
    assert sorted(os.listdir(tmp_path)) == before


def test_too_large_for_gltf_is_refused_before_the_work(tmp_path):
    """A store of 1.6 GB of vertices that nobody has written, 3.2 GB as patches."""
    with plait.create(*sheet(16), tmp_path / "large.plait", backend="pread") as store:
        store.add_attribute("points", np.float32, 3, level=10)
        store.replace_attribute("position", "points")
        store.commit()
    message = export(tmp_path / "large.plait", tmp_path / "large.glb", refused=True)
    for words in ("2 GiB", "--level", "--box", "--quantize"):
        assert words in message
    assert os.listdir(tmp_path) == ["large.plait"]


def test_counts_beyond_32_bits_are_refused_before_the_work(tmp_path):
    """4.3 thousand million vertices that nobody has written, so that they take no space."""
    with plait.create(*sheet(64), tmp_path / "large.plait", backend="compressed") as store:
        store.add_attribute("points", np.float32, 3, level=10)
        store.replace_attribute("position", "points")
        store.commit()
        assert store.counts(10).vertices == 65537 ** 2
    for ending, things in ((".ply", "4295098369 vertices"), (".stl", "8589934592 triangles")):
        message = export(tmp_path / "large.plait", tmp_path / ("large" + ending), refused=True)
        for words in (things, "at most 4294967295", "--level", "--box"):
            assert words in message
    assert os.listdir(tmp_path) == ["large.plait"]


def test_vtk_reads_the_same(stores, tmp_path):
    vtk = pytest.importorskip("vtkmodules.vtkIOXML")
    numpy_support = pytest.importorskip("vtkmodules.util.numpy_support")
    with plait.open(stores["ball"]) as store:
        mesh = store.mesh(attributes=["normal", "wide"])
    for name, kind in (("v.vtp", vtk.vtkXMLPolyDataReader), ("v.pvtp", vtk.vtkXMLPPolyDataReader)):
        export(stores["ball"], tmp_path / name, "--attribute", "normal,wide",
               *(["--pieces", "2"] if kind is vtk.vtkXMLPPolyDataReader else []))
        reader = kind()
        reader.SetFileName(str(tmp_path / name))
        reader.Update()
        read = reader.GetOutput()
        points = numpy_support.vtk_to_numpy(read.GetPoints().GetData())
        triangles = numpy_support.vtk_to_numpy(read.GetPolys().GetConnectivityArray())
        same_surface(points, triangles.reshape(-1, 3), mesh)
        assert read.GetPointData().GetNormals().GetName() == "normal"
        assert read.GetPointData().GetArray("wide").GetDataTypeAsString() == "double"


@pytest.mark.skipif(not shutil.which("assimp"), reason="assimp is not installed")
@pytest.mark.parametrize("options", [[], ["--attribute", "normal,color"]])
def test_assimp_reads_the_same_counts(stores, tmp_path, options):
    report = export(stores["ball"], tmp_path / "a.glb", *options)
    said = subprocess.run(["assimp", "info", tmp_path / "a.glb", "--raw"], capture_output=True,
                          text=True, check=True).stdout
    assert int(re.search(r"Vertices:\s+(\d+)", said).group(1)) == report["vertices"]
    assert int(re.search(r"Faces:\s+(\d+)", said).group(1)) == report["faces"]
    with plait.open(stores["ball"]) as store:
        vertices = store.mesh().vertices
    for word, expected in (("Minimum", vertices.min(0)), ("Maximum", vertices.max(0))):
        point = re.search(word + r" point\s+\((\S+) (\S+) (\S+)\)", said).groups()
        assert np.allclose([float(each) for each in point], expected, atol=1e-4)


@pytest.mark.parametrize("ending", [".ply", ".obj", ".off", ".stl"])
@pytest.mark.parametrize("part", [[], PART])
def test_meshio_reads_the_same(stores, tmp_path, ending, part):
    meshio = pytest.importorskip("meshio")
    attributes = ["--attribute", "height,wide"] if ending == ".ply" else []
    export(stores["ball"], tmp_path / ("m" + ending), *part, *attributes)
    read = meshio.read(tmp_path / ("m" + ending))
    with plait.open(stores["ball"]) as store:
        mesh = store.mesh(faces=PART_FACES if part else None)
    (kind, triangles), = read.cells_dict.items()
    assert kind == "triangle"
    same_surface(read.points.astype(np.float32), triangles, mesh)
    if attributes:
        z = read.points[:, 2]
        assert z.std() > 0.1
        for name, expected in (("height", z), ("wide_0", z), ("wide_1", -z)):
            assert np.array_equal(read.point_data[name], expected)


VALIDATE = """
const validator = require("gltf-validator"), fs = require("fs"), path = require("path");
const read = (name) => new Uint8Array(fs.readFileSync(name));
const file = process.argv[1];
const beside = (uri) => Promise.resolve(read(path.join(path.dirname(file), decodeURIComponent(uri))));
validator.validateBytes(read(file), {externalResourceFunction: beside})
  .then((report) => console.log(JSON.stringify(report)));
"""


@pytest.mark.parametrize("ending", [".glb", ".gltf"])
@pytest.mark.parametrize("options", [[], ["--quantize"], PART])
def test_validator_of_khronos_finds_no_error(stores, tmp_path, ending, options):
    """NODE_PATH names the directory where npm has put gltf-validator."""
    node = shutil.which("node")
    if node is None or subprocess.run([node, "-e", 'require("gltf-validator")'], check=False,
                                      capture_output=True).returncode:
        pytest.skip("gltf-validator is not installed")
    file = tmp_path / ("v é" + ending)
    said = export(stores["ball"], file, "--attribute", "normal,color,height", *options)
    report = json.loads(subprocess.run([node, "-e", VALIDATE, file], capture_output=True, text=True,
                                       check=True).stdout)
    assert report["issues"]["numErrors"] == report["issues"]["numWarnings"] == 0, report["issues"]
    assert report["info"]["totalVertexCount"] == said["vertices"]
    assert report["info"]["totalTriangleCount"] == said["faces"]


def test_validator_of_khronos_finds_no_error_in_what_was_mended(own_normals, tmp_path):
    """Normals of other lengths or of none, colours out of range, positions of float64 far away."""
    node = shutil.which("node")
    if node is None or subprocess.run([node, "-e", 'require("gltf-validator")'], check=False,
                                      capture_output=True).returncode:
        pytest.skip("gltf-validator is not installed")
    stores = [own_normals(lambda p: p * np.float32(3)), own_normals(lambda p: p * np.float32(0))]
    vertices, triangles = icosahedron()
    with make((vertices + [4.5e5, 5.4e6, 0], triangles), tmp_path / "w.plait", levels=2,
              dtype=np.float64) as store:
        store.add_attribute("normal", np.float64, 3)
        store.add_attribute("color", np.float32, 4)
        store.visit(lambda v: v["position"] - [4.5e5, 5.4e6, 0], reads=["position"], writes=["normal"])
        store.visit(lambda v: np.tile(np.float32([2, -1, 0.5, 1]), (len(v["position"]), 1)),
                    reads=["position"], writes=["color"])
        store.commit()
    names = ["normal"], ["normal"], ["normal", "color"]
    for store, attributes in zip([*stores, tmp_path / "w.plait"], names):
        for options in ([], ["--quantize"], ["--up", "z"]):
            file = tmp_path / "v.glb"
            export(store, file, "--attribute", ",".join(attributes), "--narrow", "--force", *options,
                   warning="vertices have")
            report = json.loads(subprocess.run([node, "-e", VALIDATE, file], capture_output=True,
                                               text=True, check=True).stdout)
            assert report["issues"]["numErrors"] == report["issues"]["numWarnings"] == 0, \
                report["issues"]


# Of each file: the coordinates of all vertices in the world, and the triangles.
IN_BLENDER = """
import sys

import bpy
import numpy as np

np.bool = bool  # Debian 12's importer of glTF takes this name, which its numpy no longer has
importers = {".glb": bpy.ops.import_scene.gltf, ".ply": bpy.ops.import_mesh.ply,
             ".stl": bpy.ops.import_mesh.stl, ".obj": bpy.ops.wm.obj_import}
for file in sys.argv[sys.argv.index("--") + 1:]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    more = {"forward_axis": "Y", "up_axis": "Z"} if file.endswith(".obj") else {}
    importers[file[-4:]](filepath=file, **more)
    points, triangles, first = [], [], 0
    for shape in bpy.data.objects:
        if shape.type != "MESH":
            continue
        of_shape = np.empty(3 * len(shape.data.vertices), np.float32)
        shape.data.vertices.foreach_get("co", of_shape)
        matrix = np.array(shape.matrix_world)
        points.append(of_shape.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3])
        corners = np.empty(len(shape.data.loops), np.int32)
        shape.data.loops.foreach_get("vertex_index", corners)
        assert all(polygon.loop_total == 3 for polygon in shape.data.polygons)
        triangles.append(corners.reshape(-1, 3) + first)
        first += len(points[-1])
    np.savez(file + ".npz", points=np.concatenate(points), triangles=np.concatenate(triangles))
"""


@pytest.mark.skipif(not shutil.which("blender"), reason="Blender is not installed")
def test_blender_reads_the_same(stores, tmp_path):
    files = [tmp_path / name for name in ("b.ply", "b.obj", "b.stl", "b.glb", "q.glb")]
    for file in files:
        export(stores["ball"], file, *(["--quantize"] if file.name == "q.glb" else []))
    (tmp_path / "script.py").write_text(IN_BLENDER, encoding="utf-8")
    done = subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "3",
                           "--python", tmp_path / "script.py", "--", *files], text=True, timeout=900,
                          capture_output=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    with plait.open(stores["ball"]) as store:
        mesh = store.mesh()
    for file in files:
        with np.load(f"{file}.npz") as found:
            points, triangles = found["points"], found["triangles"]
        if file.suffix == ".glb":  # whose y is Blender's z
            points = points[:, [0, 2, 1]] * [1, 1, -1]
        if file.name == "q.glb":
            assert len(triangles) == len(mesh.triangles)
            assert len(np.unique(points, axis=0)) == len(mesh.vertices)
            assert np.abs(points.min(0) - mesh.vertices.min(0)).max() < 1e-4
            assert np.abs(points.max(0) - mesh.vertices.max(0)).max() < 1e-4
        else:
            same_surface(points.astype(np.float32), triangles, mesh)
