#include "plait/mesh_io.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "mesh_files.h"
#include "shapes.h"

using namespace plait;
using namespace plait::mesh_files;
using Catch::Contains;
using shapes::refusal;

TEST_CASE("ReadIndexedMesh_EveryFormatAndCompression_GivesTheSameMesh") {
  const MeshDirectory directory;
  // The second mesh is large enough to fill the buffer several times.
  for (const IndexedMesh& mesh : {shapes::octahedron(), shapes::torus(100, 150)})
    for (const Sample& sample : samples(mesh)) {
      INFO(sample.name);
      CHECK(same_mesh(read_indexed_mesh(directory.file(sample.name, sample.bytes)), mesh));
      CHECK(same_mesh(read_indexed_mesh(directory.file(sample.name + ".gz", gzip(sample.bytes))),
                      mesh));
      CHECK(same_mesh(read_indexed_mesh(directory.file(sample.name + ".zst", zstd(sample.bytes))),
                      mesh));
    }
}

TEST_CASE("ReadIndexedMesh_MisleadingName_GoesByTheContent") {
  const MeshDirectory directory;
  const IndexedMesh mesh = shapes::octahedron();
  CHECK(same_mesh(read_indexed_mesh(directory.file("a.obj", ply_binary(mesh, true))), mesh));
  CHECK(same_mesh(read_indexed_mesh(directory.file("b.ply", off(mesh))), mesh));
  CHECK(same_mesh(read_indexed_mesh(directory.file("c", gzip(ply_ascii(mesh)))), mesh));
  CHECK(same_mesh(read_indexed_mesh(directory.file("d.OBJ", zstd(obj(mesh)))), mesh));
  CHECK(same_mesh(read_indexed_mesh(directory.file("e.obj.gz", obj(mesh))), mesh));
}

// Editors of DOS end a text with ^Z; fixed records and copies of preallocated files, with zeros.
TEST_CASE("ReadIndexedMesh_TextWithPaddingBehindIt_IsReadAndThatIsSaid") {
  const MeshDirectory directory;
  const IndexedMesh mesh = shapes::octahedron();
  std::vector<Sample> texts = samples(mesh);
  std::erase_if(texts, [](const Sample& sample) { return !sample.ascii; });
  REQUIRE(texts.size() == 3);
  const std::string zero(1, '\0');
  for (const Sample& sample : texts) {
    const std::string cut = sample.bytes.substr(0, sample.bytes.size() - 1);
    for (const std::string& bytes :
         {sample.bytes + "\x1a", cut + "\x1a", cut + zero, sample.bytes + std::string(512, '\0'),
          sample.bytes + std::string(3 << 18, '\0'), sample.bytes + "\x1a\r\n" + zero + "\n"}) {
      CAPTURE(sample.name, bytes.size());
      std::vector<std::string> warnings;
      CHECK(same_mesh(read_indexed_mesh(directory.file(sample.name, bytes), &warnings), mesh));
      const auto padding = std::count_if(bytes.begin(), bytes.end(),
                                         [](char c) { return c == '\0' || c == '\x1a'; });
      REQUIRE(!warnings.empty());
      CHECK_THAT(warnings.front(), Contains(fmt::format("{} byte{} of zeros or ^Z behind the text",
                                                        padding, padding == 1 ? "" : "s")));
    }
    for (const std::string& bytes :
         {zero + cut, cut + zero + "1\n", cut + std::string(3 << 18, '\0') + "1"})
      CHECK_THAT(refusal([&] { read_indexed_mesh(directory.file(sample.name, bytes)); }),
                 Contains(sample.name) && Contains("expected"));
  }
}

TEST_CASE("ReadIndexedMesh_ConcatenatedAndSkippableFrames_AreOneFile") {
  const MeshDirectory directory;
  const IndexedMesh mesh = shapes::octahedron();
  const std::string bytes = obj(mesh), half = bytes.substr(0, 40), rest = bytes.substr(40);
  const std::string skippable("\x53\x2a\x4d\x18\x05\x00\x00\x00hello", 13);
  CHECK(same_mesh(read_indexed_mesh(directory.file("a.obj.gz", gzip(half) + gzip(rest))), mesh));
  CHECK(same_mesh(read_indexed_mesh(directory.file("b.obj.zst", zstd(half) + zstd(rest))), mesh));
  CHECK(same_mesh(
      read_indexed_mesh(directory.file("c.obj.zst", skippable + zstd(half) + zstd(rest))), mesh));
}

TEST_CASE("ReadIndexedMesh_ZstdWithEveryHeaderForm_IsReadToItsEnd") {
  // One raw block after each form of frame header: with a content size of 0, 1, 2, 4 and 8 bytes,
  // and with a dictionary number of zero.
  const MeshDirectory directory;
  const IndexedMesh mesh = shapes::torus(6, 7);
  const std::string bytes = obj(mesh);
  REQUIRE(bytes.size() >= 256);
  REQUIRE(bytes.size() < 65536);
  const auto little = [](std::uint64_t value, std::size_t count) {
    std::string text;
    for (std::size_t i = 0; i < count; ++i) text += static_cast<char>(value >> (8 * i) & 0xff);
    return text;
  };
  const std::string magic = little(0xfd2fb528u, 4);
  const std::string block = little(bytes.size() << 3 | 1, 3) + bytes;
  const std::string window = little(0x40, 1);
  const std::vector<std::string> headers = {
      little(0x00, 1) + window,
      little(0x40, 1) + window + little(bytes.size() - 256, 2),
      little(0x80, 1) + window + little(bytes.size(), 4),
      little(0xc0, 1) + window + little(bytes.size(), 8),
      little(0x60, 1) + little(bytes.size() - 256, 2),
      little(0xe0, 1) + little(bytes.size(), 8),
      little(0x03, 1) + window + little(0, 4),
  };
  for (const std::string& header : headers) {
    INFO("descriptor " << static_cast<int>(static_cast<unsigned char>(header[0])));
    const std::string frame = magic + header + block;
    CHECK(same_mesh(read_indexed_mesh(directory.file("a.obj", frame)), mesh));
    CHECK_THAT(refusal([&] {
                 read_indexed_mesh(directory.file("a.obj", frame.substr(0, frame.size() - 1)));
               }),
               Contains("expected whole zstd data"));
  }
  // The header announces a checksum, but it is missing or wrong.
  const std::string checked = magic + little(0x04, 1) + window + block;
  for (const std::string& end : {std::string(), std::string(4, 'x')})
    CHECK_THAT(refusal([&] { read_indexed_mesh(directory.file("a.obj", checked + end)); }),
               Contains("expected whole zstd data"));
}

TEST_CASE("ReadIndexedMesh_DamagedGzip_IsRefusedWithAPlaceOfTheFile") {
  const MeshDirectory directory;
  // "v 0 0 0\n" in a stored block whose length contradicts its complement.
  const std::string damaged("\x1f\x8b\x08\0\0\0\0\0\0\x03\x01\x08\0\0\0v 0 0 0\n", 23);
  CHECK_THAT(refusal([&] { read_indexed_mesh(directory.file("a.obj.gz", damaged)); }),
             Contains("expected whole gzip data, found it damaged or cut short in the first 23 "
                      "bytes of the file"));
}

TEST_CASE("ReadIndexedMesh_UnknownContent_IsRefused") {
  const MeshDirectory directory;
  const auto read = [&](const std::string& name, const std::string& bytes) {
    return refusal([&] { read_indexed_mesh(directory.file(name, bytes)); });
  };
  CHECK_THAT(
      read("mesh.3mf", "solid \x01 cube"),
      Contains("mesh.3mf, byte 0: expected PLY or OFF content or a name that ends in .obj or "
               ".stl, found 'solid ? cube'"));
  CHECK_THAT(read("mesh.ply", ""), Contains("an empty file"));
  CHECK_THAT(read("mesh.gz", gzip("")), Contains("an empty file"));
  CHECK_THAT(refusal([&] { read_indexed_mesh(directory.path()); }), Contains("a regular file"));
}

TEST_CASE("ReadIndexedMesh_MissingFile_IsNotFound") {
  const MeshDirectory directory;
  try {
    read_indexed_mesh(directory.path() / "none.ply");
    FAIL("nothing thrown");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kNotFound);
    CHECK_THAT(error.what(), Contains("none.ply"));
  }
}

TEST_CASE("ReadBaseMesh_NonManifoldFile_IsRefusedWithItsName") {
  const MeshDirectory directory;
  const auto path = directory.file("fins.obj",
                                   "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 1\n"
                                   "f 1 2 3\nf 2 1 4\nf 1 2 5\n");
  CHECK(refusal([&] { read_base_mesh(path); }) ==
        path.string() +
            ", counted from 0: edge 0-1: expected at most two faces, found 3: faces 0, 1, 2; plait "
            "check counts such places, and plait remesh repairs them");
}

TEST_CASE("WritePly_AnyMesh_ReadsBackTheSame") {
  const MeshDirectory directory;
  const IndexedMesh mesh = shapes::torus(120, 130);
  const auto path = directory.path() / "out.ply";
  write_ply(path, mesh);
  CHECK(same_mesh(read_indexed_mesh(path), mesh));
  write_ply(path, shapes::octahedron());
  CHECK(same_mesh(read_indexed_mesh(path), shapes::octahedron()));
  CHECK(directory.file_count() == 1);
}

TEST_CASE("WritePly_Failure_LeavesNothingBehind") {
  const MeshDirectory directory;
  IndexedMesh mesh = shapes::octahedron();
  std::filesystem::create_directories(directory.path() / "taken.ply" / "inside");
  CHECK_THROWS_AS(write_ply(directory.path() / "taken.ply", mesh), Error);
  CHECK_THROWS_AS(write_ply(directory.path() / "none" / "out.ply", mesh), Error);
  mesh.positions[4].y = 1e39;
  CHECK_THAT(refusal([&] { write_ply(directory.path() / "large.ply", mesh); }),
             Contains("vertex 4: expected a position within float32, found 1e+39"));
  mesh.positions[4].y = 0;
  mesh.faces[2][1] = 6;
  CHECK_THAT(refusal([&] { write_ply(directory.path() / "range.ply", mesh); }),
             Contains("face 2: expected vertices below 6, found 6"));
  CHECK(directory.file_count() == 1);
}
