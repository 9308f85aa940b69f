#include "export/vector_text.h"

#include <fmt/format.h>

#include <cstring>
#include <iterator>

#include "export/vertex_stream.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

template <class Real>
void append_vectors(fmt::memory_buffer& text, std::string_view before,
                    std::span<const std::byte> records) {
  Vector3<Real> vector;
  for (; records.size() >= sizeof(vector); records = records.subspan(sizeof(vector))) {
    std::memcpy(&vector, records.data(), sizeof(vector));
    fmt::format_to(std::back_inserter(text), "{}{} {} {}\n", before, vector.x, vector.y, vector.z);
  }
}

}  // namespace

void write_vector_lines(const ExportTask& task, OutputStream& output, AttributeId attribute,
                        std::string_view before, bool counts) {
  const bool wide = task.schema(attribute).type == ComponentType::kFloat64;
  std::uint64_t done = 0;
  fmt::memory_buffer text;
  stream_vertices(task.store, std::span(&attribute, 1), task.patches,
                  [&](auto records, std::size_t count) {
                    text.clear();
                    if (wide)
                      append_vectors<double>(text, before, records[0]);
                    else
                      append_vectors<float>(text, before, records[0]);
                    output.write(std::string_view(text.data(), text.size()));
                    if (counts) done += count;
                    task.progress(counts ? done : task.vertices());
                  });
}

PLAIT_END_NAMESPACE
