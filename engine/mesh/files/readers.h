// readers.h: one reader per file format, and their common parts. Each reader reads an Input from
// start to end. It checks every number and index when it reads it, so that messages can name the
// place.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/files/input.h"
#include "mesh/files/mesh_stream.h"
#include "plait/extend/attributed_mesh.h"
#include "plait/mesh_io.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

using Warnings = std::vector<std::string>;

/// What a reader shall read, and what it has to say.
struct Reading {
  MeshSink* sink = nullptr;      ///< who gets the mesh, part by part; for PLY files
  bool attributes = false;       ///< those of vertices, if the format names and types them
  bool face_attributes = false;  ///< those of faces, likewise
  Warnings* warnings = nullptr;
  /// What the file has and the mesh has not, each with its number: "texture coordinates of 8
  /// vertices".
  std::vector<std::string> left_out = {};
  /// Whether some of it are numbers of vertices, which a PLY file can have as properties.
  bool leaves_out_of_vertices = false;

  void warn(std::string text) const {
    if (warnings != nullptr) warnings->push_back(std::move(text));
  }
  /// "NUMBER ONE" or "NUMBER MANY"; nothing for 0.
  void leave_out(std::uint64_t number, std::string_view one, std::string_view many);
  /// "WHAT of NUMBER ONE" or "WHAT of NUMBER MANY"; nothing for 0.
  void leave_out_of(std::string_view what, std::uint64_t number, std::string_view one,
                    std::string_view many);
  /// "WHAT of NUMBER vertices"; nothing for 0.
  void leave_out_of_vertices(std::string_view what, std::uint64_t number);
};

AttributedMesh read_ply(Input& input, Reading& reading);
AttributedMesh read_obj(Input& input, Reading& reading);
AttributedMesh read_off(Input& input, Reading& reading);
AttributedMesh read_stl(Input& input, Reading& reading);

/// The length of the keyword with which a word begins that begins an OFF file, or 0: OFF, with any
/// of the prefixes ST, C, N, 4, n. Digits may follow it without a blank, as in the set ModelNet.
std::size_t off_keyword_bytes(std::string_view word);

/// Whether a file is binary STL by its size.
bool is_binary_stl(Input& input);

PLAIT_END_NAMESPACE
