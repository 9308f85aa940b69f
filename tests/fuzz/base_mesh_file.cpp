// A file base.mesh with the right checksum. If the reader accepts it, the mesh is exactly the mesh
// in the bytes.
//
// Input: a byte, V and F of the description; then the file, or, if the byte is odd, form and
// exponent of the positions and the content of the frame.
#include "format/base_mesh_file.h"

#include "format/checksum.h"
#include "format/packed_mesh.h"
#include "input_bytes.h"
#include "mesh_target.h"

using namespace plait;
using namespace plait::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  InputBytes input(data, size);
  const bool is_content = input.take<std::uint8_t>() % 2 == 1;
  const std::uint64_t vertices = input.take<std::uint32_t>(), faces = input.take<std::uint32_t>();
  PositionWords of_content;
  if (is_content)
    of_content = {static_cast<PositionForm>(input.take<std::uint32_t>()),
                  static_cast<std::int32_t>(input.take<std::uint32_t>())};
  std::vector<std::byte> bytes(input.rest().begin(), input.rest().end());
  if (is_content) bytes = base_mesh_file(vertices, faces, of_content, bytes);
  const File file(path_of(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()),
                  OpenMode::kRead);
  accepts({ErrorCode::kCorruption, ErrorCode::kOutOfMemory}, [&] {
    const BaseMesh mesh =
        read_base_mesh_file(file, {bytes.size(), checksum_of(bytes)}, vertices, faces);
    check_base_mesh(mesh);
    require(mesh.vertex_count() == vertices && mesh.face_count() == faces);
    const PositionWords words = words_of(mesh.positions());
    require(words.valid());
    const auto again = unpack_mesh(pack_mesh(mesh, words), vertices, faces, words);
    require(again.has_value());
    require(std::ranges::equal(again->faces, mesh.faces()));
    require(std::ranges::equal(std::as_bytes(std::span(again->positions)),
                               std::as_bytes(mesh.positions())));
  });
  return 0;
}
