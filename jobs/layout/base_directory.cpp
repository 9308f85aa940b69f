#include "layout/base_directory.h"

#include <system_error>
#include <utility>

#include "format/file_names.h"
#include "io/made_mark.h"
#include "layout/temporary_file.h"
#include "parts/sealed_file.h"
#include "plait/error.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr char kLayoutName[] = "layout", kKind[] = "plait layout";
constexpr std::uint64_t kMostLayoutBytes = 1u << 16;
constexpr std::string_view kCure = ": make it again with plait layout";

}  // namespace

void write_base_directory(const Directory& directory, const BaseCounts& counts,
                          const StoredSize& base_mesh) {
  FieldWriter fields = begin_sealed(kKind);
  fields.put_text(to_string(kLayoutOfBaseDirectory), kMostText, "the layout");
  for (const std::uint64_t number : {counts.vertices, counts.edges, counts.faces,
                                     counts.border_edges, base_mesh.bytes, base_mesh.checksum})
    fields.put(number);
  const std::vector<std::byte> bytes = seal(fields);
  File file(directory, kLayoutName, OpenMode::kCreate);
  file.write_at(0, bytes);
  file.sync();
  file.close();
}

void remove_base_directory(const Directory& directory) {
  for (const char* const name :
       {kLayoutName, kBaseMeshName, kBaseIndexName, kTemporaryName, kMadeMarkName})
    directory.remove_if_possible(name);
}

bool is_base_directory(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored) &&
         std::filesystem::exists(path / kLayoutName, ignored);
}

std::shared_ptr<const BaseIndexPages> open_base_pages(const std::filesystem::path& path) {
  const Directory directory(path);
  const File file(directory, kLayoutName, OpenMode::kRead);
  SealedFile sealed(file, {kKind}, kMostLayoutBytes);
  FieldReader& fields = sealed.fields();
  const std::string layout = fields.take_text(kMostText, "the layout");
  fields.require(layout == to_string(kLayoutOfBaseDirectory), "the layout", layout);
  ExpectedBase expected;
  expected.cure = kCure;
  for (std::uint64_t* const number : {&expected.counts.vertices, &expected.counts.edges,
                                      &expected.counts.faces, &expected.counts.border_edges}) {
    *number = fields.take<std::uint64_t>("a count");
    fields.require(*number < kNoId, "a count", *number);
  }
  const auto bytes = fields.take<std::uint64_t>("the size of base.mesh");
  expected.checksum = fields.take<std::uint64_t>("the checksum of base.mesh");
  fields.require(fields.bytes_left() == 0, "the end", fields.bytes_left());
  File mesh(directory, kBaseMeshName, OpenMode::kRead);
  if (const std::uint64_t found = mesh.size(); found != bytes)
    throw Error(ErrorCode::kCorruption, fmt::format("open {}: {} bytes, expected {}{}",
                                                    mesh.path().native(), found, bytes, kCure))
        .about(mesh.path());
  return std::make_shared<const BaseIndexPages>(File(directory, kBaseIndexName, OpenMode::kRead),
                                                expected, std::move(mesh));
}

BaseMesh open_base_directory(const std::filesystem::path& path) {
  return BaseMesh::of(open_base_pages(path));
}

PLAIT_END_NAMESPACE
