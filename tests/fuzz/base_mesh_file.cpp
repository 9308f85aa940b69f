// A file base.mesh with the right checksum. If the reader accepts it, the mesh is exactly the mesh
// in the bytes.
#include "store/base_mesh_file.h"

#include "mesh_target.h"
#include "store/checksum.h"

using namespace plait;
using namespace plait::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kHeaderBytes = 32;
  const std::span<const std::byte> bytes = std::as_bytes(std::span(data, size));
  const File file(path_of(data, size), OpenMode::kRead);
  accepts({ErrorCode::kCorruption}, [&] {
    const BaseMesh mesh = read_base_mesh_file(file, {size, checksum_of(bytes)});
    check_base_mesh(mesh);
    const auto positions = std::as_bytes(mesh.positions());
    const auto faces = std::as_bytes(mesh.faces());
    require(size == kHeaderBytes + positions.size() + faces.size());
    require(std::ranges::equal(positions, bytes.subspan(kHeaderBytes, positions.size())));
    require(std::ranges::equal(faces, bytes.last(faces.size())));
  });
  return 0;
}
