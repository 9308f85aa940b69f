// ply_header.h: the header of a PLY file. Source: G. Turk, "The PLY Polygon File Format", 1994.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/files/input.h"
#include "plait/attribute.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

enum class PlyFormat : std::uint8_t { kAscii, kLittleEndian, kBigEndian };

struct PlyProperty {
  std::string name;
  ComponentType type = ComponentType::kFloat32;
  bool is_list = false;
  ComponentType count_type = ComponentType::kUint8;  ///< of a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;  ///< as the header claims
  std::vector<PlyProperty> properties;

  /// The fewest bytes of one element in a binary file: its lists have no entries.
  std::uint64_t least_bytes() const;
  bool has_lists() const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<PlyElement> elements;
  std::uint64_t lines = 0;
  std::vector<std::string> texture_files;  ///< of comments "TextureFile NAME"
};

/// Consumes the header with its last line end. Lines end in \n, \r\n or \r, all of them like the
/// first line.
/// Errors: kInvalidArgument with the line number.
PlyHeader read_ply_header(Input& input);

PLAIT_END_NAMESPACE
