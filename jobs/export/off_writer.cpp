#include <fmt/format.h>

#include <iterator>

#include "export/vector_text.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void write_off_level(const ExportTask& task, OutputStream& output) {
  // The third number, of edges, has no meaning.
  output.write(fmt::format("OFF\n{} {} 0\n", task.vertices(), task.triangles()));
  write_vector_lines(task, output, task.position, "", true);
  fmt::memory_buffer text;
  for_each_numbered_triangle(
      task.patches,
      [&](FaceId, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
        fmt::format_to(std::back_inserter(text), "3 {} {} {}\n", a, b, c);
      },
      [&](std::uint64_t triangles) {
        output.write(std::string_view(text.data(), text.size()));
        text.clear();
        task.progress(task.vertices() + triangles);
      });
}

PLAIT_END_NAMESPACE
