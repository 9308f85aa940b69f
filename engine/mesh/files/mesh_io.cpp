#include "plait/mesh_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <new>
#include <stdexcept>

#include "mesh/connectivity.h"
#include "mesh/files/readers.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using Reader = IndexedMesh (*)(Input&, Warnings*);

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

/// The extension of the format, without that of the compression.
std::string format_extension(const std::filesystem::path& path) {
  const std::string last = lower_extension(path);
  return last == ".gz" || last == ".zst" ? lower_extension(path.stem()) : last;
}

Reader find_reader(Input& input) {
  constexpr std::size_t kLookBytes = 16;
  input.ensure(kLookBytes);
  const std::string_view start = input.unread().substr(0, kLookBytes);
  const std::string_view word = start.substr(0, start.find_first_of(" \t\r\n#"));
  if (word == "ply") return read_ply;
  if (is_off_keyword(word)) return read_off;
  const std::string extension = format_extension(input.path());
  if (extension == ".obj") return read_obj;
  if (extension == ".off") return read_off;
  if (extension == ".stl" && !start.empty()) return read_stl;
  input.refuse_at_byte(
      0, fmt::format("expected PLY or OFF content or a name that ends in .obj or .stl, found {}",
                     start.empty() ? "an empty file" : in_quotes(start)));
}

template <class Element>
void release_excess(std::vector<Element>& elements) {
  if (elements.capacity() - elements.size() > elements.size() / 8) elements.shrink_to_fit();
}

}  // namespace

bool FaceDivider::add(VertexId vertex) {
  if (corners_ == 0) first_ = vertex;
  if (corners_ == 3) ++polygons_;
  if (corners_ >= 2) {
    if (triangles_.size() >= kMaxFaces) return false;
    triangles_.push_back({first_, previous_, vertex});
  }
  previous_ = vertex;
  ++corners_;
  return true;
}

void FaceDivider::report(const Input& input, Warnings* warnings) const {
  if (polygons_ > 0 && warnings != nullptr)
    warnings->push_back(
        fmt::format("{}: {} faces of more than three corners divided into triangles",
                    input.path().native(), polygons_));
}

IndexedMesh read_indexed_mesh(const std::filesystem::path& path, Warnings* warnings) {
  return with_memory_errors("read " + path.native(), [&] {
    Input input(path);
    IndexedMesh mesh = find_reader(input)(input, warnings);
    release_excess(mesh.positions);
    release_excess(mesh.faces);
    return mesh;
  });
}

AttributedMesh read_attributed_mesh(const std::filesystem::path& path, Warnings* warnings,
                                    NotFinite not_finite) {
  return with_memory_errors("read " + path.native(), [&] {
    Input input(path);
    input.keep_not_finite(not_finite == NotFinite::kKeep);
    const Reader reader = find_reader(input);
    AttributedMesh read = reader == read_ply ? read_ply_with_attributes(input, warnings)
                                             : AttributedMesh{reader(input, warnings)};
    release_excess(read.mesh.positions);
    release_excess(read.mesh.faces);
    for (MeshAttribute& attribute : read.attributes) release_excess(attribute.records);
    return read;
  });
}

BaseMesh read_base_mesh(const std::filesystem::path& path, Warnings* warnings) {
  IndexedMesh mesh = read_indexed_mesh(path, warnings);
  try {
    return BaseMesh::build(std::move(mesh), path.native(), warnings);
  } catch (const Error& error) {
    throw Error(error).about(path);
  }
}

PLAIT_END_NAMESPACE
