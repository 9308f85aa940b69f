// The files of a plan, read as docs/format.md describes them.
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "engine/store/format_reader.h"
#include "plait/extend/parts.h"
#include "plait/mesh_io.h"
#include "plait/registry.h"
#include "support/file_bytes.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;

std::uint64_t checksum(const std::string& bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

/// The fields of `plan` or `done.I`, whose checksum is right.
class FileFields {
 public:
  explicit FileFields(const fs::path& path) : bytes_(content_of(path)) {
    REQUIRE(bytes_.size() > 8);
    std::memcpy(&checksum_, bytes_.data() + bytes_.size() - 8, 8);
    bytes_.resize(bytes_.size() - 8);
    REQUIRE(checksum(bytes_) == checksum_);
  }
  std::uint64_t checksum_at_end() const { return checksum_; }
  template <class T>
  T take() {
    T value{};
    REQUIRE(at_ + sizeof value <= bytes_.size());
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  std::string take_bytes(std::size_t count) {
    REQUIRE(at_ + count <= bytes_.size());
    return bytes_.substr(std::exchange(at_, at_ + count), count);
  }
  std::string take_text() { return take_bytes(take<std::uint32_t>()); }
  bool is_at_end() const { return at_ == bytes_.size(); }

 private:
  std::string bytes_;
  std::uint64_t checksum_ = 0;
  std::size_t at_ = 0;
};

/// [vertex] the lowest edge of the face that decides which part the vertex belongs to.
std::vector<std::uint32_t> deciding_edges(const format::Store& store) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> numbers;
  for (std::uint32_t edge = 0; edge < store.edges.size(); ++edge)
    numbers[std::minmax(store.edges[edge].start, store.edges[edge].end)] = edge;
  std::vector<std::uint32_t> next_of(store.positions.size(), 0xffffffff),
      deciding(store.positions.size());
  for (const std::array<std::uint32_t, 3>& face : store.faces) {
    std::array<std::uint32_t, 3> of_face{};
    for (std::size_t corner = 0; corner < 3; ++corner)
      of_face[corner] = numbers.at(std::minmax(face[corner], face[(corner + 1) % 3]));
    for (std::size_t corner = 0; corner < 3; ++corner) {
      // A border edge comes before all neighbours.
      const std::uint32_t vertex = face[corner], next = face[(corner + 1) % 3],
                          key = store.edges[of_face[corner]].is_border() ? 0 : next + 1;
      if (key >= next_of[vertex]) continue;
      next_of[vertex] = key;
      deciding[vertex] = *std::ranges::min_element(of_face);
    }
  }
  return deciding;
}

struct Planned {
  std::array<std::uint64_t, 3> counts{};  ///< vertices, edges, faces
  std::string uuid, scheme;
  std::uint32_t base_level = 0, finest_level = 0;
  std::vector<std::uint32_t> starts;
};

Planned read_plan(FileFields& fields, const fs::path& plan) {
  Planned planned;
  CHECK(fields.take_text() == "plait plan");
  CHECK(fields.take<std::uint32_t>() == 1);
  planned.uuid = fields.take_bytes(16);
  CHECK(!fields.take_text().empty());  // the program
  for (std::uint64_t& count : planned.counts) count = fields.take<std::uint64_t>();
  const std::string base = content_of(plan / "base.mesh");
  CHECK(fields.take<std::uint64_t>() == base.size());
  CHECK(fields.take<std::uint64_t>() == checksum(base));
  CHECK(fields.take<std::uint64_t>() == 4096);  // bytes of a block
  fields.take_bytes(16);
  planned.base_level = fields.take<std::uint32_t>();
  planned.finest_level = fields.take<std::uint32_t>();
  CHECK(fields.take<std::uint8_t>() == 2);  // float64
  CHECK(fields.take<std::uint8_t>() == 1);  // normals
  CHECK(fields.take<std::uint8_t>() == 2);  // no limit positions; one file for all levels
  planned.scheme = fields.take_text();
  for (int text = 0; text < 4; ++text) fields.take_text();  // layout, backend, pipelines
  const auto parts = fields.take<std::uint32_t>();
  for (std::uint32_t part = 0; part < parts; ++part) {
    planned.starts.push_back(fields.take<std::uint32_t>());
    fields.take_bytes(40);
  }
  CHECK(fields.is_at_end());
  return planned;
}

}  // namespace

TEST_CASE("plan and done.I and records are as the page on formats describes them") {
  const TemporaryDirectory directory;
  const fs::path plan = directory.path() / "plan", joined = directory.path() / "joined.plait";
  PartsRequest request;
  request.mesh = directory.path() / "mesh.ply";
  // With borders and inner vertices.
  write_ply(request.mesh, sheet(5, 4));
  request.plan = plan;
  request.parts = 3;
  request.levels = 2;
  request.normals = true;
  request.precision = ComponentType::kFloat64;
  request.block_bytes = 4096;
  plan_parts(request, default_backends());
  for (std::uint32_t part = 0; part < 3; ++part) make_part(plan, part, {}, default_backends());
  join_parts(plan, joined, {}, default_backends());
  const format::Store store = format::read_store(joined);

  FileFields plan_fields(plan / "plan");
  const Planned planned = read_plan(plan_fields, plan);
  CHECK(planned.counts == std::array<std::uint64_t, 3>{store.positions.size(), store.edges.size(),
                                                       store.faces.size()});
  CHECK(planned.uuid == std::string(store.uuid.begin(), store.uuid.end()));
  CHECK(planned.scheme == store.scheme);
  CHECK(planned.finest_level == 2);
  REQUIRE(planned.starts.size() == 3);

  const std::vector<std::uint32_t> deciding = deciding_edges(store);
  for (std::uint32_t part = 0; part < 3; ++part) {
    CAPTURE(part);
    FileFields done(plan / ("done." + std::to_string(part)));
    CHECK(done.take_text() == "plait part");
    CHECK(done.take<std::uint32_t>() == 1);
    CHECK(done.take_bytes(16) == planned.uuid);
    CHECK(done.take<std::uint64_t>() == plan_fields.checksum_at_end());
    CHECK(done.take<std::uint32_t>() == part);
    const fs::path made = plan / done.take_text();
    CHECK(made.filename().string().starts_with("part." + std::to_string(part) + "-"));
    CHECK(!done.take_text().empty());  // the description
    const auto files = done.take<std::uint32_t>();
    CHECK(files == store.attributes.size());
    for (std::uint32_t file = 0; file < files; ++file) {
      const std::string name = done.take_text();
      CHECK(done.take<std::uint64_t>() == fs::file_size(made / name));
      CHECK(content_of(made / name) == content_of(joined / name));
    }
    const std::string tables = "version.1.shard" + std::to_string(part);
    CHECK(done.take<std::uint64_t>() == checksum(content_of(made / tables)));
    const std::string records = content_of(made / "records");
    CHECK(done.take<std::uint64_t>() == checksum(records));
    done.take_bytes(24);                                // digest, seconds
    CHECK(!done.take_text().empty());                   // host
    CHECK(!done.take_text().empty());                   // user
    CHECK(done.take<std::uint64_t>() > 1'700'000'000);  // begun
    CHECK(done.take<double>() > 0);                     // seconds of processors
    CHECK(done.take<std::uint64_t>() > 1'000'000);      // memory
    CHECK(done.is_at_end());

    std::string expected;
    const std::uint32_t end = part < 2 ? planned.starts[part + 1] : 0xffffffff;
    for (const format::Attribute& attribute : store.attributes)
      for (std::size_t vertex = 0; vertex < deciding.size(); ++vertex)
        if (deciding[vertex] >= planned.starts[part] && deciding[vertex] < end) {
          const auto from =
              attribute.base.begin() + static_cast<std::ptrdiff_t>(vertex * attribute.record_bytes);
          expected.append(from, from + static_cast<std::ptrdiff_t>(attribute.record_bytes));
        }
    CHECK(records == expected);
  }
}

}  // namespace plait::test
