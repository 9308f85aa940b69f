#include "job_rules.h"

#include <fmt/format.h>

#include <utility>

#include "base/text.h"
#include "io/machine.h"
#include "layout/base_directory.h"
#include "mesh/weld.h"
#include "plait/mesh_io.h"
#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

BaseMesh mesh_of_file(const std::filesystem::path& file, std::optional<double> weld,
                      std::uint64_t& merged, std::vector<std::string>& warnings) {
  if (is_base_directory(file)) {
    if (!weld) return open_base_directory(file);
    throw JobError(
        ErrorCode::kInvalidArgument,
        fmt::format("{}: expected a file to weld, found a base mesh in files, whose faces "
                    "are connected",
                    file.native()),
        "weld");
  }
  if (!weld) return read_base_mesh(file, &warnings);
  AttributedMesh read{read_indexed_mesh(file, &warnings)};
  merged = plait::weld(read, *weld, file.native(), warnings);
  return BaseMesh::build(std::move(read.mesh), file.native(), &warnings);
}

BaseMesh in_input_order(BaseMesh mesh) {
  if (mesh.stored_base().mesh == nullptr) return mesh;
  return mesh.with_face_order(mesh.input_maps().faces);
}

bool has_order(const BaseMesh& mesh, LayoutKind kind) {
  return kind == kLayoutOfBaseDirectory && mesh.stored_base().mesh != nullptr;
}

LaidOutMesh laid_out(BaseMesh mesh, LayoutKind kind) {
  if (has_order(mesh, kind) && mesh.piece_bytes() != 0) return {std::move(mesh), kind, {}};
  if (!has_order(mesh, kind)) return lay_out(in_input_order(std::move(mesh)), kind);
  const LayoutSpans spans = measure_spans(mesh);
  return {std::move(mesh), kind, spans};
}

Compression compression_of(const std::vector<std::string>& texts) {
  Compression compression;
  for (const std::string& text : texts) compression.add(text);
  return compression;
}

void check_attributes_of_scheme(const Compression& compression, bool normals) {
  compression.check_attributes(normals ? std::vector<std::string>{"position", "normal"}
                                       : std::vector<std::string>{"position"});
}

void warn_of_unknown_attributes(const std::vector<std::string>& compress,
                                std::vector<std::string> own,
                                const std::vector<AttributeSchema>& others, const JobWatch& watch) {
  if (!watch.warn) return;
  for (const AttributeSchema& schema : others) own.push_back(schema.name);
  for (const std::string& text : compress) try {
      compression_of({text}).check_attributes(own);
    } catch (const Error& error) {
      watch.warn(fmt::format("{}; the text has no effect", error.what()));
    }
}

ErrorBounds error_bounds_of(const std::vector<std::string>& texts) {
  ErrorBounds bounds;
  for (const std::string& text : texts) bounds.add(text);
  return bounds;
}

PipelinesOf pipelines_of(const Compression& compression) {
  if (compression.empty()) return {};
  return [compression](const AttributeSchema& schema) { return compression.pipeline_of(schema); };
}

PipelinesOf pipelines_of(const Compression& compression, bool rounds,
                         const std::optional<std::string>& backend,
                         const BackendRegistry& backends) {
  if (!rounds || !compression.empty()) return pipelines_of(compression);
  const bool is_chosen = backend && !backend->empty() && *backend != kAutomaticBackend;
  if (is_chosen && !backends.find(*backend).traits.compressed) return {};
  return [](const AttributeSchema& schema) { return Compression().pipeline_of(schema); };
}

JobError needs_compression(std::string_view verb, const RegisteredBackend& backend) {
  return {ErrorCode::kInvalidArgument,
          fmt::format("{}: a compression needs a backend that compresses, and {} does not: choose "
                      "backend compressed",
                      verb, backend.name),
          "backend"};
}

std::optional<JobError> lacks_memory(std::string_view what, std::uint64_t needed_bytes) {
  const std::uint64_t found = available_memory_bytes();
  if (needed_bytes <= found) return {};
  return JobError(ErrorCode::kOutOfMemory,
                  fmt::format("{}: expected {} of memory, found {}", what,
                              format_bytes(needed_bytes), format_bytes(found)),
                  "ignore-size");
}

void check_memory(std::string_view what, std::uint64_t needed_bytes, bool ignore) {
  if (ignore) return;
  if (const auto refusal = lacks_memory(what, needed_bytes)) throw JobError(*refusal);
}

std::optional<std::string> disk_for_sorts(std::string_view what, const std::filesystem::path& out,
                                          std::uint64_t needed_bytes) {
  constexpr std::uint64_t kMuch = std::uint64_t{1} << 30;
  const std::uint64_t free = free_disk_bytes(out);
  if (needed_bytes > free)
    throw Error(ErrorCode::kNoSpace,
                fmt::format("{}: until the end about {} of disk are needed beside {}, and {} are "
                            "free",
                            what, format_bytes(needed_bytes), out.native(), format_bytes(free)));
  if (needed_bytes <= kMuch) return {};
  return fmt::format(
      "until the end, files beside {} take up to about {} of the {} of disk that are "
      "free",
      out.native(), format_bytes(needed_bytes), format_bytes(free));
}

void warn_of_fewer_threads(std::string_view what, int taken, int asked, std::uint64_t budget_bytes,
                           const std::function<void(const std::string&)>& warn) {
  const int wanted = thread_count(asked, what);
  if (warn && taken < wanted)
    warn(
        fmt::format("{}: {} threads of {}: the blocks and the scratch memory of more do not fit "
                    "the budget of {} (--memory)",
                    what, taken, wanted, format_bytes(budget_bytes)));
}

PLAIT_END_NAMESPACE
