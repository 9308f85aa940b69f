#include <fmt/format.h>

#include <iterator>

#include "export/vector_text.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void write_obj_level(const ExportTask& task, OutputStream& output) {
  output.write(fmt::format("# plait: level {}, {} vertices, {} triangles\n", task.level,
                           task.vertices(), task.triangles()));
  write_vector_lines(task, output, task.position, "v ", true);
  for (const AttributeId normal : task.extras)
    write_vector_lines(task, output, normal, "vn ", false);

  const bool normals = !task.extras.empty();
  fmt::memory_buffer text;
  for_each_numbered_triangle(
      task.patches,
      [&](FaceId, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
        // Numbers start at 1. A vertex and its normal have the same number.
        if (normals)
          fmt::format_to(std::back_inserter(text), "f {0}//{0} {1}//{1} {2}//{2}\n", a + 1, b + 1,
                         c + 1);
        else
          fmt::format_to(std::back_inserter(text), "f {} {} {}\n", a + 1, b + 1, c + 1);
      },
      [&](std::uint64_t triangles) {
        output.write(std::string_view(text.data(), text.size()));
        text.clear();
        task.progress(task.vertices() + triangles);
      });
}

PLAIT_END_NAMESPACE
