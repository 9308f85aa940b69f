// The optional file view: what a viewer needs for the first picture of a store, in one file that
// one request brings. docs/format.md, "view". No version names the file; it names its version.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "plait/attribute.h"
#include "plait/base_mesh.h"
#include "plait/extend/block_table.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// An attribute, and the files that have its records raw, one after another.
struct ViewAttribute {
  AttributeSchema schema;
  std::string base_file;
  std::vector<std::string> level_files;  ///< [level - base level - 1]
};

struct View {
  StoreUuid store;
  std::uint64_t version = 0;
  int base_level = 0;
  std::vector<ViewAttribute> attributes;
  std::uint32_t position = 0;  ///< in `attributes`
  /// [face] refinements, as FaceDepths has them; empty if all faces have all levels.
  std::span<const std::uint8_t> depths;
  /// [depth * faces + face] how far a patch that is drawn with its levels up to base level + depth
  /// may be from what the store has; depths below the number of levels of the positions.
  std::vector<float> errors;
};

/// `positions` are those of the base vertices as the store has them. Errors: kInvalidArgument for a
/// position that is not finite; kOutOfMemory.
std::vector<std::byte> encode_view(const View& view, const BaseMesh& mesh,
                                   std::span<const Vector3<double>> positions);

/// What a view must say of the store.
struct ViewedStore {
  StoreUuid uuid{};
  std::uint64_t vertex_count = 0, face_count = 0;
  std::span<const std::uint8_t> depths = {};  ///< as View::depths
};

/// Throws kCorruption unless `bytes` are a view as docs/format.md describes it, of this store; for
/// messages, `path` is its file.
void check_view(std::span<const std::byte> bytes, const std::filesystem::path& path,
                const ViewedStore& expected);

/// The version of the store whose view it is. REQUIRES: check_view().
std::uint64_t view_version(std::span<const std::byte> bytes);

/// The file of a store; empty if there is none. Errors: as check_view(); kIo.
std::vector<std::byte> read_view_file(const Directory& store, const ViewedStore& expected);

PLAIT_END_NAMESPACE
