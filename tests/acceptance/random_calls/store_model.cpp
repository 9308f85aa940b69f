#include "acceptance/random_calls/store_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/store_access.h"
#include "plait/notes.h"
#include "plait/registry.h"

namespace plait::test {
namespace {

std::uint32_t mixed(std::uint64_t number) {
  number = (number ^ number >> 31) * 0x9e3779b97f4a7c15u;
  return static_cast<std::uint32_t>(number >> 32);
}

float pattern_float(std::uint32_t seed, std::uint64_t component) {
  return static_cast<float>(mixed(component * 977 + seed) % 1024) / 64 - 8;
}

}  // namespace

bool Content::Attribute::is_finished() const {
  // A replacement that has not got its name, as a subdivision leaves it that ends early.
  return !schema.name.ends_with(" (new)") && base_finished &&
         std::ranges::all_of(levels, [](const Level& level) { return level.finished; });
}

Content::Attribute* Content::find(std::string_view name) {
  for (Attribute& attribute : attributes)
    if (attribute.schema.name == name) return &attribute;
  return nullptr;
}

bool Content::is_finished() const {
  return std::ranges::all_of(attributes, [](const auto& each) { return each.is_finished(); });
}

bool Content::operator==(const Content& other) const {
  const auto same_level = [](const Level& a, const Level& b) {
    return a.finished == b.finished && (!a.finished || a.bytes == b.bytes);
  };
  const auto same = [&](const Attribute& a, const Attribute& b) {
    return a.schema == b.schema && a.base_finished == b.base_finished &&
           (!a.base_finished || a.base == b.base) &&
           std::ranges::equal(a.levels, b.levels, same_level);
  };
  return std::ranges::equal(attributes, other.attributes, same) &&
         face_attributes == other.face_attributes && texts == other.texts;
}

void fill_pattern(const AttributeSchema& schema, std::uint32_t seed, std::uint64_t first,
                  std::span<std::byte> bytes) {
  if (schema.type == ComponentType::kFloat32) {
    for (std::size_t at = 0; at < bytes.size(); at += 4) {
      const float number = pattern_float(seed, (first + at) / 4);
      std::memcpy(&bytes[at], &number, 4);
    }
    return;
  }
  for (std::size_t at = 0; at < bytes.size(); ++at)
    bytes[at] = static_cast<std::byte>(mixed((first + at) * 31 + seed));
}

void change_pattern(const AttributeSchema& schema, std::span<std::byte> bytes) {
  if (schema.type == ComponentType::kFloat32) {
    for (std::size_t at = 0; at < bytes.size(); at += 4) {
      float number = 0;
      std::memcpy(&number, &bytes[at], 4);
      number = number * 0.5f + 1;
      std::memcpy(&bytes[at], &number, 4);
    }
    return;
  }
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(std::to_integer<unsigned>(byte) + 3);
}

Content content_of(Store& store) {
  Content content;
  content.provenance = store.provenance();
  content.texts = store.notes().texts();
  for (const AttributeSchema& schema : store.notes().face_attributes()) {
    const auto numbers = std::as_const(store).notes().face_bytes(schema.name);
    content.face_attributes.push_back({schema, {numbers.begin(), numbers.end()}});
  }
  const Reader reader(store);
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    const AttributeInfo& info = store.attributes()[id];
    Content::Attribute& attribute = content.attributes.emplace_back();
    attribute.schema = info.schema;
    attribute.base_finished = StoreAccess::base_records_of(store, id).is_finished();
    attribute.base.resize(store.base().vertex_count() * info.schema.record_bytes());
    if (attribute.base_finished)
      std::ranges::copy(std::as_const(store).base_bytes(id), attribute.base.begin());
    for (int level = 1; level <= info.finest_level; ++level) {
      Content::Level& read = attribute.levels.emplace_back();
      const LevelFile& file = StoreAccess::level_file(std::as_const(store), id, level);
      read.finished = file.is_finished();
      if (!read.finished) {
        read.bytes.resize(file.geometry.total_bytes());  // of which nothing is known
        continue;
      }
      reader.for_each_block_of_bytes(info.schema.name, level, 0, reader.vertex_count(level),
                                     [&](std::uint64_t, std::span<const std::byte> bytes) {
                                       read.bytes.insert(read.bytes.end(), bytes.begin(),
                                                         bytes.end());
                                     });
    }
  }
  return content;
}

std::string difference(const Store& store, const Content& expected) {
  if (store.attributes().size() != expected.attributes.size())
    return fmt::format("{} attributes, expected {}", store.attributes().size(),
                       expected.attributes.size());
  if (store.notes().texts() != expected.texts) return "other texts";
  if (store.notes().face_attributes().size() != expected.face_attributes.size())
    return fmt::format("{} face attributes, expected {}", store.notes().face_attributes().size(),
                       expected.face_attributes.size());
  for (std::size_t at = 0; at < expected.face_attributes.size(); ++at) {
    const AttributeSchema& schema = store.notes().face_attributes()[at];
    if (schema != expected.face_attributes[at].schema ||
        !std::ranges::equal(store.notes().face_bytes(schema.name),
                            expected.face_attributes[at].numbers))
      return fmt::format("face attribute '{}' differs", schema.name);
  }
  const Reader reader(store);
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    const AttributeInfo& info = store.attributes()[id];
    const Content::Attribute& attribute = expected.attributes[id];
    if (info.schema != attribute.schema)
      return fmt::format("attribute '{}', expected '{}'", info.schema.name, attribute.schema.name);
    if (info.finest_level != attribute.finest())
      return fmt::format("'{}' has level {}, expected {}", info.schema.name, info.finest_level,
                         attribute.finest());
    try {
      if (!std::ranges::equal(store.base_bytes(id), attribute.base))
        return fmt::format("base records of '{}' differ", info.schema.name);
      if (!attribute.base_finished)
        return fmt::format("base records of '{}' are unfinished and were read", info.schema.name);
    } catch (const Error& error) {
      if (attribute.base_finished || error.code() != ErrorCode::kBadState)
        return fmt::format("read base records of '{}': {}", info.schema.name, error.what());
    }
    for (int level = 1; level <= info.finest_level; ++level) {
      const Content::Level& right = attribute.levels[static_cast<std::size_t>(level - 1)];
      std::size_t offset = 0;
      bool same = true;
      try {
        reader.for_each_block_of_bytes(
            info.schema.name, level, 0, reader.vertex_count(level),
            [&](std::uint64_t, std::span<const std::byte> bytes) {
              same = same && offset + bytes.size() <= right.bytes.size() &&
                     std::memcmp(bytes.data(), right.bytes.data() + offset, bytes.size()) == 0;
              offset += bytes.size();
            });
      } catch (const Error& error) {
        if (!right.finished && error.code() == ErrorCode::kBadState) continue;
        return fmt::format("read level {} of '{}': {}", level, info.schema.name, error.what());
      }
      if (!right.finished)
        return fmt::format("level {} of '{}' is unfinished and was read", level, info.schema.name);
      if (!same || offset != right.bytes.size())
        return fmt::format("level {} of '{}' differs", level, info.schema.name);
    }
  }
  return {};
}

Store loaded(const BaseMesh& base, const Content& content) {
  StoreOptions options;
  options.backend = "memory";
  options.block_bytes = 4096;
  Store store = Store::create({}, base, options, default_backends());
  for (const Content::Attribute& attribute : content.attributes) {
    const AttributeId id = store.add_attribute(attribute.schema, attribute.finest());
    std::ranges::copy(attribute.base, store.base_bytes(id).begin());
    for (int level = 1; level <= attribute.finest(); ++level) {
      const Bytes& bytes = attribute.levels[static_cast<std::size_t>(level - 1)].bytes;
      LevelFile& file = StoreAccess::level_file(store, id, level);
      Session session = StoreAccess::open_session(store);
      for (std::uint64_t block = 0; block < file.geometry.block_count(); ++block) {
        const PinnedBlock pinned = session.pin(file, block, Access::kOverwrite);
        std::memcpy(pinned.bytes().data(), bytes.data() + file.geometry.block_offset(block),
                    file.geometry.block_bytes(block));
      }
    }
  }
  StoreAccess::set_provenance(store, content.provenance);
  return store;
}

Bytes patch_of(const BaseMesh& base, const Content::Attribute& attribute, FaceId face, int level) {
  const Topology mesh = base.topology();
  const std::size_t record_bytes = attribute.schema.record_bytes();
  const std::int64_t size = std::int64_t{1} << level;
  Bytes patch;
  for (std::int64_t j = 0; j <= size; ++j)
    for (std::int64_t i = 0; i + j <= size; ++i) {
      const std::byte* from = nullptr;
      if (is_corner(level, i, j)) {
        from = attribute.base.data() +
               mesh.faces[face][static_cast<std::size_t>(corner_of(i, j))] * record_bytes;
      } else {
        const EdgeIndex at = edge_index(mesh, {face, level, i, j});
        const Slot slot =
            base.geometry(relative_to_base(at.level, 0), record_bytes, 1).slot(at.edge);
        from = attribute.levels[static_cast<std::size_t>(at.level - 1)].bytes.data() + slot.offset +
               static_cast<std::size_t>(slot_position(at.level, slot.shape, at.row, at.column)) *
                   record_bytes;
      }
      patch.insert(patch.end(), from, from + record_bytes);
    }
  return patch;
}

}  // namespace plait::test
