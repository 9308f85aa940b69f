#include "engine/store/sample_store.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <iterator>
#include <utility>

#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

/// S. Vigna, "splitmix64", 2015: a step of the generator as a hash.
std::uint64_t mixed(std::uint64_t value) {
  value += 0x9e3779b97f4a7c15u;
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9u;
  value = (value ^ (value >> 27)) * 0x94d049bb133111ebu;
  return value ^ (value >> 31);
}

}  // namespace

StoreOptions sample_options(const std::string& backend, std::uint64_t block_bytes) {
  return {.backend = backend,
          .durability = Durability::kNone,
          .block_bytes = block_bytes,
          .budget_bytes = 1 << 20};
}

std::vector<AttributeSchema> sample_schemas() {
  return {{"position", ComponentType::kFloat32, 3}, {"mass", ComponentType::kFloat64, 1},
          {"flag", ComponentType::kUint8, 1},       {"id", ComponentType::kUint32, 1},
          {"wide", ComponentType::kInt16, 255},     {"noise", ComponentType::kUint8, 5}};
}

std::vector<std::byte> sample_slot(const AttributeSchema& schema, int level, VertexId start,
                                   VertexId end, std::size_t bytes) {
  std::uint64_t seed = mixed(std::min(start, end));
  seed = mixed(seed ^ std::max(start, end));
  seed = mixed(seed ^ static_cast<std::uint64_t>(level));
  for (const char letter : schema.name) seed = mixed(seed ^ static_cast<std::uint64_t>(letter));
  const bool noise = schema.name == "noise";
  const std::size_t width = component_bytes(schema.type);
  std::vector<std::byte> slot(bytes);
  for (std::size_t i = 0; i < bytes; ++i) {
    const std::uint64_t value =
        noise || i % width == 0 ? mixed(seed + i) & (noise ? 0xff : 0x1f) : (seed >> (i % width));
    slot[i] = static_cast<std::byte>(value & 0xff);
  }
  return slot;
}

std::vector<std::byte> sample_base(const Store& store, const AttributeSchema& schema) {
  std::vector<std::byte> bytes;
  for (VertexId vertex = 0; vertex < store.base().vertex_count(); ++vertex)
    std::ranges::copy(sample_slot(schema, 0, vertex, vertex, schema.record_bytes()),
                      std::back_inserter(bytes));
  return bytes;
}

std::vector<std::byte> sample_level(const Store& store, const AttributeSchema& schema, int level) {
  const std::size_t n = std::size_t{1} << (level - store.base_level() - 1);
  std::vector<std::byte> bytes;
  for (const Edge& edge : store.base().edges())
    std::ranges::copy(
        sample_slot(schema, level, edge.start, edge.end,
                    (edge.is_border() ? n * (n + 1) / 2 : n * n) * schema.record_bytes()),
        std::back_inserter(bytes));
  return bytes;
}

AttributeId add_sample(Store& store, const AttributeSchema& schema, int levels) {
  const AttributeId id = store.add_attribute(schema);
  std::ranges::copy(sample_base(store, schema), store.base_bytes(id).begin());
  for (int level = store.base_level() + 1; level <= store.base_level() + levels; ++level) {
    store.add_level(id);
    write_level(store, id, level, sample_level(store, schema, level));
  }
  return id;
}

void write_level(Store& store, AttributeId attribute, int level, std::span<const std::byte> bytes) {
  LevelFile& file = StoreAccess::level_file(store, attribute, level);
  REQUIRE(bytes.size() == file.geometry.total_bytes());
  Session session = StoreAccess::open_session(store);
  for (std::uint64_t block = 0; block < file.geometry.block_count(); ++block) {
    const PinnedBlock pinned = session.pin(file, block, Access::kOverwrite);
    std::ranges::copy(bytes.first(pinned.bytes().size()), pinned.bytes().begin());
    bytes = bytes.subspan(pinned.bytes().size());
  }
}

std::vector<std::byte> read_level(Store& store, AttributeId attribute, int level) {
  LevelFile& file = StoreAccess::level_file(store, attribute, level);
  std::vector<std::byte> bytes;
  Session session = StoreAccess::open_session(store);
  for (std::uint64_t block = 0; block < file.geometry.block_count(); ++block) {
    const PinnedBlock pinned = session.pin(file, block, Access::kRead);
    bytes.insert(bytes.end(), pinned.bytes().begin(), pinned.bytes().end());
  }
  return bytes;
}

bool holds_sample(Store& store, AttributeId attribute) {
  const AttributeInfo info = store.attributes()[attribute];
  if (!std::ranges::equal(std::as_const(store).base_bytes(attribute),
                          sample_base(store, info.schema)))
    return false;
  for (int level = store.base_level() + 1; level <= info.finest_level; ++level)
    if (read_level(store, attribute, level) != sample_level(store, info.schema, level))
      return false;
  return true;
}

void commit_anew(Store& store) {
  StoreAccess::set_provenance(store, store.provenance());
  store.commit();
}

void leave_for_frames(Store& store, std::uint64_t bytes) {
  StoreAccess::pager(store).set_aside(store.options().budget_bytes - bytes);
  REQUIRE(StoreAccess::pager(store).budget_bytes() == bytes);
}

std::vector<std::string> durable_backends() {
  std::vector<std::string> names = usable_backends();
  std::erase_if(
      names, [](const std::string& name) { return !default_backends().find(name).traits.durable; });
  return names;
}

std::set<std::string> file_names(const std::filesystem::path& directory) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(directory))
    names.insert(entry.path().filename().string());
  return names;
}

std::vector<std::byte> file_bytes(const std::filesystem::path& file) {
  std::vector<std::byte> bytes(std::filesystem::file_size(file));
  const File opened(file, OpenMode::kRead);
  opened.read_at(0, bytes);
  return bytes;
}

void overwrite_byte(const std::filesystem::path& file, std::uint64_t offset, std::byte value) {
  File opened(file, OpenMode::kReadWrite);
  opened.write_at(offset, std::span(&value, 1));
}

bool names(const Error& error, const std::vector<std::string>& words) {
  const std::string message = error.what();
  for (const std::string& word : words)
    if (message.find(word) == std::string::npos) {
      WARN("'" << word << "' is not in: " << message);
      return false;
    }
  return true;
}

}  // namespace plait::test
