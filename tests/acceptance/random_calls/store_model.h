// What a store must contain, as bytes, without the library's pager, backends and files.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "plait/reader.h"
#include "plait/store.h"
#include "plait/subdivide.h"

namespace plait::test {

using Bytes = std::vector<std::byte>;

/// The content of a store.
struct Content {
  struct Level {
    Bytes bytes;  ///< all slots, one after another
    bool finished = true;
  };
  struct Attribute {
    AttributeSchema schema;
    Bytes base;
    bool base_finished = true;
    std::vector<Level> levels;  ///< [level - 1]: the stores of the model have base level 0
    int finest() const { return static_cast<int>(levels.size()); }
    bool is_finished() const;
  };
  struct FaceAttribute {
    AttributeSchema schema;
    Bytes numbers;
    bool operator==(const FaceAttribute&) const = default;
  };
  std::vector<Attribute> attributes;
  std::vector<FaceAttribute> face_attributes;
  Texts texts;
  Provenance provenance;

  Attribute* find(std::string_view name);
  bool is_finished() const;
  bool operator==(const Content& other) const;
};

/// Bytes that every kernel accepts as records: floats are small and finite. `first` is the place of
/// the first byte in its level.
void fill_pattern(const AttributeSchema& schema, std::uint32_t seed, std::uint64_t first,
                  std::span<std::byte> bytes);
/// What an update pass of the test does with the bytes of whole records.
void change_pattern(const AttributeSchema& schema, std::span<std::byte> bytes);

/// What is wrong with the store's content; empty if it is that of the model. Unfinished levels must
/// refuse to be read.
std::string difference(const Store& store, const Content& expected);
/// The content as the store has it now.
Content content_of(Store& store);
/// A store in memory, of the same base mesh, with this content.
Store loaded(const BaseMesh& base, const Content& content);
/// The records of a patch in row order.
Bytes patch_of(const BaseMesh& base, const Content::Attribute& attribute, FaceId face, int level);

}  // namespace plait::test
