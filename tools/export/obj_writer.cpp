#include <fmt/format.h>

#include <cstring>
#include <iterator>

#include "export/format_writers.h"
#include "export/vertex_stream.h"

namespace plait {
namespace {

/// Appends the shortest decimals that give the same numbers when they are read.
template <class Real>
void append_vectors(fmt::memory_buffer& text, const char* keyword,
                    std::span<const std::byte> records) {
  Vector3<Real> vector;
  for (; records.size() >= sizeof(vector); records = records.subspan(sizeof(vector))) {
    std::memcpy(&vector, records.data(), sizeof(vector));
    fmt::format_to(std::back_inserter(text), "{} {} {} {}\n", keyword, vector.x, vector.y,
                   vector.z);
  }
}

void write_vectors(const ExportTask& task, AttributeId attribute, const char* keyword,
                   bool counts) {
  const bool wide = task.store.attributes()[attribute].schema.type == ComponentType::kFloat64;
  std::uint64_t done = 0;
  fmt::memory_buffer text;
  stream_vertices(task.store, std::span(&attribute, 1), task.level,
                  [&](auto records, std::size_t count) {
                    text.clear();
                    if (wide)
                      append_vectors<double>(text, keyword, records[0]);
                    else
                      append_vectors<float>(text, keyword, records[0]);
                    task.output.write(std::string_view(text.data(), text.size()));
                    if (counts) done += count;
                    task.progress(counts ? done : task.vertices());
                  });
}

}  // namespace

void write_obj_level(const ExportTask& task) {
  task.output.write(fmt::format("# plait: level {}, {} vertices, {} triangles\n", task.level,
                                task.vertices(), task.triangles()));
  write_vectors(task, task.position, "v", true);
  for (const AttributeId normal : task.extras) write_vectors(task, normal, "vn", false);

  const bool normals = !task.extras.empty();
  fmt::memory_buffer text;
  for_each_numbered_triangle(
      task.store.base(), task.numbering, task.refinements,
      [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
        // Numbers start at 1. A vertex and its normal have the same number.
        if (normals)
          fmt::format_to(std::back_inserter(text), "f {0}//{0} {1}//{1} {2}//{2}\n", a + 1, b + 1,
                         c + 1);
        else
          fmt::format_to(std::back_inserter(text), "f {} {} {}\n", a + 1, b + 1, c + 1);
      },
      [&](std::uint64_t triangles) {
        task.output.write(std::string_view(text.data(), text.size()));
        text.clear();
        task.progress(task.vertices() + triangles);
      });
}

}  // namespace plait
