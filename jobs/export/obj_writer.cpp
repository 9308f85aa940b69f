#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "export/vector_text.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The normals at creases: they follow those of the vertices, face by face. Numbers start at 1.
class ObjSideNormals {
 public:
  explicit ObjSideNormals(const ExportTask& task) : task_(task), next_(task.vertices() + 1) {}

  /// Returns how many they are.
  std::uint64_t write(OutputStream& output) const {
    if (task_.creases == nullptr) return 0;
    std::uint64_t count = 0;
    PatchPositions positions(task_.store, task_.level);
    fmt::memory_buffer text;
    for (const FaceId face : task_.patches.faces()) {
      task_.progress(task_.vertices());
      if (!task_.creases->points().has_any(face)) continue;
      positions.read(face);
      const auto at = [&](std::int64_t i, std::int64_t j) { return positions.at(i, j); };
      text.clear();
      task_.creases->for_each(
          face, at, [&](std::int64_t, std::int64_t, const Vector3<float>& normal) {
            fmt::format_to(std::back_inserter(text), "vn {} {} {}\n", normal.x, normal.y, normal.z);
            ++count;
          });
      output.write(std::string_view(text.data(), text.size()));
    }
    return count;
  }

  /// The number of the normal of a vertex in a face. Faces come in the order of write(). `vertex`
  /// is the number of the vertex in the file.
  std::uint64_t number(FaceId face, std::uint64_t vertex) {
    if (task_.creases == nullptr) return vertex;
    if (face != face_) enter(face);
    const auto found = std::ranges::lower_bound(numbers_, vertex, {}, &Numbers::first);
    return found != numbers_.end() && found->first == vertex ? found->second : vertex;
  }

 private:
  using Numbers = std::pair<std::uint64_t, std::uint64_t>;  ///< of a vertex, of its normal

  void enter(FaceId face) {
    face_ = face;
    numbers_.clear();
    task_.creases->points().for_each_point(face, [&](std::int64_t i, std::int64_t j) {
      numbers_.emplace_back(task_.patches.number({face, task_.patches.refinements(), i, j}) + 1,
                            next_++);
    });
    std::ranges::sort(numbers_);
  }

  const ExportTask& task_;
  std::uint64_t next_;  ///< the first normal of the next face
  FaceId face_ = kNoId;
  std::vector<Numbers> numbers_;
};

}  // namespace

std::uint64_t write_obj_level(const ExportTask& task, OutputStream& output) {
  output.write(fmt::format("# plait: level {}, {} vertices, {} triangles\n", task.level,
                           task.vertices(), task.triangles()));
  write_vector_lines(task, output, task.position, "v ", true);
  for (const AttributeId normal : task.extras)
    write_vector_lines(task, output, normal, "vn ", false);
  ObjSideNormals sides(task);
  const std::uint64_t side_normals = sides.write(output);

  const bool normals = !task.extras.empty();
  fmt::memory_buffer text;
  for_each_numbered_triangle(
      task.patches,
      [&](FaceId face, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
        // Numbers start at 1. A vertex and its normal have the same number, except at creases.
        if (normals)
          fmt::format_to(std::back_inserter(text), "f {}//{} {}//{} {}//{}\n", a + 1,
                         sides.number(face, a + 1), b + 1, sides.number(face, b + 1), c + 1,
                         sides.number(face, c + 1));
        else
          fmt::format_to(std::back_inserter(text), "f {} {} {}\n", a + 1, b + 1, c + 1);
      },
      [&](std::uint64_t triangles) {
        output.write(std::string_view(text.data(), text.size()));
        text.clear();
        task.progress(task.vertices() + triangles);
      });
  return side_normals;
}

PLAIT_END_NAMESPACE
